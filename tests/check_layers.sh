#!/usr/bin/env bash
# A folder includes only what stands left of it, and foreign libraries only in their bridge files.
set -u
cd "$(dirname "$0")/.."
bad=0

# folder: the folders it may include from, besides itself
while read -r folder allowed; do
    hits=$(grep -nE '^#include "(base|grammar|enumerate|mbs|optimise|catalogues|cli|tests)/' "$folder"/*.[ch] 2>/dev/null |
           grep -vE "#include \"($(tr ' ' '|' <<< "$folder $allowed"))/")
    if [ -n "$hits" ]; then
        echo "$hits" | sed "s|\$|   ($folder may include: $allowed)|"
        bad=1
    fi
done <<'TABLE'
base
grammar base
enumerate base grammar
mbs base grammar
optimise base grammar mbs
catalogues base grammar mbs optimise
cli base grammar enumerate mbs optimise catalogues
TABLE

# header of a foreign library: the files that may see it
while read -r header files; do
    hits=$(grep -nE "^#include <$header" {base,grammar,enumerate,mbs,optimise,catalogues,cli}/*.[ch] 2>/dev/null |
           grep -vE "^($(tr ' ' '|' <<< "$files")):")
    if [ -n "$hits" ]; then
        echo "$hits" | sed "s|\$|   (bridge files of $header: $files)|"
        bad=1
    fi
done <<'TABLE'
gsl/ cli/main.c optimise/solver_gsl.c optimise/lowdiscrepancy.c mbs/modes_eigen.c mbs/panel.c mbs/modes_fft.c
nlopt optimise/solver_nlopt.c
jansson grammar/json.c cli/model.c cli/catalogue_add.c
cairo catalogues/picture.c
gif_lib catalogues/gif.c
planarity grammar/planar.c
sqlite3 catalogues/store_internal.h
igraph enumerate/canon.c
mpi.h cli/spread.c
cvode mbs/cvode.c
ida mbs/ida.c
(nvector|sun) mbs/sundials_internal.h
TABLE

[ $bad -eq 0 ] && echo "layers: fine"
exit $bad
