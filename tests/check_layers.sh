#!/usr/bin/env bash
# A folder includes only what its row names, and foreign libraries only in their bridge files.
set -u
cd "$(dirname "$0")/.."
bad=0

# folder: the folders it may include from, besides itself; a name without a slash stands for all of that stage
while read -r folder allowed; do
    [ -n "$folder" ] || continue
    pattern=$(for a in $folder $allowed; do
                  case $a in */*) echo "$a/[^/\"]*\"" ;; *) [ "$a" = "$folder" ] && echo "$a/[^/\"]*\"" || echo "$a/" ;; esac
              done | paste -sd '|')
    hits=$(grep -nE '^#include "(base|grammar|enumerate|mbs|optimise|catalogues|surface|cli|studio|tests)/' "$folder"/*.[ch] 2>/dev/null |
           grep -vE "#include \"($pattern)")
    if [ -n "$hits" ]; then
        echo "$hits" | sed "s|\$|   ($folder may include: $allowed)|"
        bad=1
    fi
done <<'TABLE'
base
grammar/text base
grammar/topology base grammar/text
grammar/linkage base grammar/text grammar/topology
grammar/functions base grammar/text grammar/linkage
grammar/model base grammar/text grammar/topology grammar/linkage grammar/functions
grammar/family base grammar/text grammar/functions
enumerate base grammar
mbs/plan base grammar
mbs/batch base grammar mbs/plan
mbs/kinematics base grammar mbs/plan mbs/batch
mbs/constraints base grammar
mbs/ode base
mbs/space base grammar mbs/constraints mbs/elastic mbs/batch
mbs/elastic base grammar
mbs/equations base grammar mbs/constraints mbs/elastic mbs/space
mbs/clearance base grammar mbs/constraints mbs/ode mbs/elastic mbs/equations
mbs/dynamics base grammar mbs/constraints mbs/ode mbs/elastic mbs/space mbs/equations
mbs/reduced base grammar mbs/plan mbs/constraints mbs/equations mbs/dynamics
mbs/run base grammar mbs/constraints mbs/ode mbs/elastic mbs/space mbs/equations mbs/dynamics
mbs/equilibrium base grammar mbs/constraints mbs/ode mbs/elastic mbs/space mbs/equations mbs/dynamics mbs/run
mbs/formulations base grammar mbs/plan mbs/constraints mbs/ode mbs/elastic mbs/space mbs/equations mbs/dynamics mbs/reduced mbs/run mbs/equilibrium
mbs/analysis base grammar mbs/constraints mbs/ode mbs/elastic mbs/space mbs/equations mbs/clearance mbs/dynamics mbs/run mbs/equilibrium mbs/formulations
mbs/drives base grammar mbs/constraints mbs/elastic mbs/ode mbs/space mbs/equations mbs/dynamics mbs/equilibrium mbs/formulations mbs/analysis
optimise/task base grammar mbs
optimise/problem base grammar mbs optimise/task
optimise/solvers base grammar mbs optimise/task optimise/problem
optimise/search base grammar mbs optimise/task optimise/problem optimise/solvers
optimise/report base grammar mbs optimise/task optimise/problem optimise/solvers optimise/search
optimise/precision base grammar mbs optimise/task optimise/problem optimise/solvers optimise/search optimise/report
optimise/topology base grammar enumerate mbs optimise/task optimise/problem optimise/solvers optimise/search optimise/report
catalogues/draw base grammar mbs optimise
catalogues/exchange base grammar mbs optimise catalogues/draw
catalogues/curves base grammar mbs optimise
catalogues/store base grammar mbs optimise catalogues/draw catalogues/curves
catalogues/build base grammar enumerate mbs optimise catalogues/draw catalogues/curves catalogues/store
catalogues/pages base grammar mbs optimise catalogues/draw catalogues/store
surface base grammar enumerate mbs optimise catalogues
cli/program base grammar enumerate mbs optimise catalogues
cli/topologies base grammar enumerate mbs optimise catalogues cli/program
cli/motion base grammar enumerate mbs optimise catalogues cli/program
cli/family base grammar enumerate mbs optimise catalogues cli/program cli/motion
cli/robot base grammar enumerate mbs optimise catalogues cli/program cli/motion
cli/fit base grammar enumerate mbs optimise catalogues cli/program
cli/draw base grammar enumerate mbs optimise catalogues cli/program
cli/catalogue base grammar enumerate mbs optimise catalogues cli/program
cli/bench base grammar enumerate mbs optimise catalogues cli/program
studio base grammar enumerate mbs optimise catalogues
cli/studio base grammar enumerate mbs optimise catalogues cli/program studio
TABLE

# every folder with sources has its row
for d in $(find base grammar enumerate mbs optimise catalogues surface cli studio -name '*.[ch]' -printf '%h\n' | sort -u); do
    grep -qE "^$d( |\$)" "$0" || [ "$d" = cli ] || { echo "$d: no row in tests/check_layers.sh"; bad=1; }
done

# header of a foreign library: the files that may see it
while read -r header files; do
    hits=$(grep -rnE "^#include <$header" --include=*.[ch] base grammar enumerate mbs optimise catalogues surface cli studio |
           grep -vE "^($(tr ' ' '|' <<< "$files")):")
    if [ -n "$hits" ]; then
        echo "$hits" | sed "s|\$|   (bridge files of $header: $files)|"
        bad=1
    fi
done <<'TABLE'
gsl/ base/gsl_errors.c optimise/solvers/solver_gsl.c optimise/solvers/lowdiscrepancy.c base/eigen.c mbs/ode/panel.c mbs/analysis/modes_fft.c
nlopt optimise/solvers/solver_nlopt.c
jansson grammar/text/json.c grammar/text/json_read.c cli/program/file_kind.c cli/draw/cmd_gallery.c catalogues/build/build_linkages.c studio/studio_internal.h
cairo catalogues/draw/picture.c
gif_lib catalogues/draw/gif.c
planarity grammar/topology/planar.c
sqlite3 catalogues/store/store_internal.h
igraph enumerate/canon.c
microhttpd studio/server.c
mpi.h cli/program/mpi_jobs.c
cvode mbs/ode/cvode.c
ida mbs/ode/ida.c
(nvector|sun) mbs/ode/sundials_internal.h
suitesparse base/sparse_lu.c
TABLE

# functions of the C library whose last bits depend on the processor: base/real.h has its own
hits=$(grep -rnE '^#include <(math|complex|tgmath)\.h>|[^a-z_](exp2|exp10|expm1|log1p|cbrt|asinh|acosh|atanh|erfc?|[lt]gamma|csqrt|clog|cpow|csin|ccos)\(' \
       --include=*.[ch] base grammar enumerate mbs optimise catalogues surface cli studio | grep -vE '^base/real(_complex)?\.h:')
if [ -n "$hits" ]; then
    echo "$hits" | sed 's/$/   (use base\/real.h)/'
    bad=1
fi

[ $bad -eq 0 ] && echo "layers: fine"
exit $bad
