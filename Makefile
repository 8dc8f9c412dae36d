# linkwright: make, make test, make demo, make check, make bench, make install.  See README.md.
# CC, CFLAGS, CPPFLAGS, LDFLAGS, PREFIX, LIBDIR, DESTDIR: from the environment or the command line
VERSION := $(shell sed -n 's/^\#define LW_VERSION_STRING "\(.*\)"/\1/p' linkwright.h)
SO_MAJOR = 0
B        = $(if $(MPI),build/mpi,build)
ifeq ($(origin CC),default)
CC       = gcc
endif
ifeq ($(origin CFLAGS),undefined)
CFLAGS   = -O2
# HOT: rooms of loops that run millions of times; PLAIN: rooms without any, which compile in half the time
HOT      = base enumerate grammar/functions grammar/topology mbs/plan mbs/batch mbs/kinematics mbs/constraints mbs/ode \
           mbs/dynamics mbs/reduced mbs/run mbs/equilibrium mbs/formulations mbs/space mbs/equations mbs/elastic \
           optimise/problem optimise/solvers optimise/search catalogues/curves tests/bench
PLAIN    = cli/program cli/topologies cli/motion cli/robot cli/family cli/fit cli/draw cli/catalogue cli/studio studio surface grammar/text \
           grammar/linkage grammar/model grammar/family optimise/task optimise/report catalogues/draw catalogues/exchange \
           catalogues/pages catalogues/build catalogues/store
LEVEL    = $(if $(filter $(HOT:%=%/%) catalogues/draw/chain_%,$<),-O3,$(or $(QUICK),$(if $(filter $(PLAIN:%=%/%) tests/%,$<),-O1)))
# own builds start in less than half the time: at fixed addresses, with archives in the place of shared libraries.  Those who set
# CFLAGS, as packagers do, choose for themselves
PIE      = -no-pie
PROGRAM_LIBS = $(ARCHIVES)
else
PROGRAM_LIBS = $(LIBS)
endif
# tests mostly call the library: without optimisation they compile in half the time; not those with long loops of their own, and
# test_cli_promises.c, which asks for an optimised build
LOOPS    = beam_space chain_layout cli_promises curves layers
QUICK    = $(if $(filter-out $(LOOPS:%=tests/test_%.c),$(filter tests/%,$<)),-O0)
PREFIX  ?= /usr/local
LIBDIR  ?= $(PREFIX)/lib
STAGES   = base grammar enumerate mbs optimise catalogues surface     # each includes only those before it

PKGS     = gsl nlopt jansson sqlite3
LATE     = igraph cairo        # loaded when they are first called, as libmicrohttpd is (base/library.h)
DEPS     = gcc libc6-dev pkg-config libgsl-dev libigraph-dev libnlopt-dev libjansson-dev libcairo2-dev \
           libgif-dev libplanarity-dev libsundials-dev libsqlite3-dev libsuitesparse-dev libmicrohttpd-dev
PEERS    = g++ libsimbody-dev libmujoco-dev                         # optional: measured beside by `bench mbs`
SUNDIALS = -lsundials_cvode -lsundials_ida -lsundials_nvecserial   # Debian 12 has no .pc for it
WARN     = -Wall -Wextra -Wpedantic -Wshadow -Wstrict-prototypes -Wmissing-prototypes -Wvla -Werror=switch -Wno-unknown-pragmas
# library and program run in threads with little stack (docs/promises.md); tests and builds for sanitizers need more
STACK    = $(if $(filter tests/%,$<)$(findstring sanitize,$(CFLAGS)),,-Wframe-larger-than=65536)
# contraction off: the same bits on every processor; no errno, no trap flags: sqrt vectorises
FLOAT    = -ffp-contract=off -fno-math-errno -fno-trapping-math
INCS    := -I$B $(shell pkg-config --cflags $(PKGS) $(LATE) 2>/dev/null)
# as needed: only a test links one of those that are loaded late
PRIVATE  = -lplanarity -lgif -lklu $(SUNDIALS) -lpthread -ldl -lm       # those without a .pc file
LIBS    := -Wl,--as-needed $(shell pkg-config --libs $(PKGS) $(LATE) 2>/dev/null) $(PRIVATE)
ifdef MPI                       # make MPI=1: linkwright chains --mpi, in build/mpi
INCS    += -DLW_MPI $(shell mpicc --showme:compile)
MPI_LIBS := $(shell mpicc --showme:link)
LIBS    += $(MPI_LIBS)
endif
# archives in the place of shared libraries, where there are any
ARCHIVE  = $(filter /%,$(shell $(CC) -print-file-name=$(1:-l%=lib%.a)))
ARCHIVES = $(foreach l,$(LIBS) -lamd -lcolamd -lbtf -lsuitesparseconfig,$(or $(if \
           $(filter-out -lm -lpthread -ldl $(LATE:%=-l%) $(MPI_LIBS),$l),$(call ARCHIVE,$l)),$l))
COMPILE  = $(CC) -std=c17 -D_GNU_SOURCE -DLW_VERSION='"$(VERSION)"' $(WARN) $(STACK) $(FLOAT) -fPIC -fvisibility=hidden -I. $(INCS) $(CPPFLAGS) $(CFLAGS) $(LEVEL) -MMD -MP

# kernel*.c hold the hot loops; they are compiled once per instruction set, which is chosen at run time
ISAS    := $(if $(filter x86_64,$(shell uname -m)),x86-64 x86-64-v3 x86-64-v4,native)
# gcc must not split a loop's selections into paths that each take their own square root; vectors are passed to
# inlined functions only; the other two passes take a third of the compile time and gain nothing.  Nor do those of KERNEL_LEAN
# in loops that are already written in vectors
# gcc 12 with a stack protector stores vectors in arrays of the stack that it has not aligned for them
# -O2 makes them up to five times slower, also where CFLAGS come from a packager
KERNEL   = $(if $(filter -O2,$(CFLAGS)),-O3) -mprefer-vector-width=512 -Wno-psabi -fno-stack-protector \
           $(if $(findstring clang,$(CC)),,-fno-thread-jumps -fno-tree-pre -fno-gcse-after-reload -fno-var-tracking $(KERNEL_LEAN))
KERNEL_LEAN = $(if $(filter %/kernel_higher.c %/kernel_continuation.c,$<),-fno-gcse -fno-tree-vrp -fno-ipa-cp -fno-tree-sink \
           -fno-tree-loop-distribution -fno-tree-loop-distribute-patterns -fno-split-loops -fno-unswitch-loops \
           -fno-tree-slp-vectorize -fno-schedule-insns2 -fno-code-hoisting)
HOT_SRC := $(wildcard mbs/batch/kernel*.c mbs/ode/kernel*.c mbs/space/kernel*.c)
LIB_SRC := $(filter-out $(HOT_SRC),$(wildcard $(STAGES:%=%/*.c) $(STAGES:%=%/*/*.c)))
HOT_OBJ := $(foreach isa,$(ISAS),$(HOT_SRC:%.c=$B/%-$(isa).o))
LIB_OBJ := $(HOT_OBJ) $(LIB_SRC:%.c=$B/%.o)
CLI_OBJ := $(patsubst %.c,$B/%.o,$(wildcard cli/*.c cli/*/*.c studio/*.c))
FUZZ    := $(patsubst %.c,$B/%,$(wildcard tests/fuzz/fuzz_*.c))
TESTS   := $(patsubst %.c,$B/%,$(wildcard tests/test_*.c)) $(FUZZ)
SAMPLES := $(patsubst %.c,$B/%,$(wildcard docs/examples/*.c))     # of the shared library and linkwright.h alone
BENCHES := $(patsubst %.c,$B/%,$(filter-out %/peer_mujoco.c,$(wildcard tests/bench/*.c)))
# other programs' solvers, never part of linkwright, built where their headers are
SIMBODY := $(shell pkg-config --libs simbody 2>/dev/null)
PEER_BIN := $(if $(and $(SIMBODY),$(shell command -v g++ 2>/dev/null)),$B/peers/simbody) \
            $(if $(wildcard /usr/include/mujoco/mujoco.h /usr/local/include/mujoco/mujoco.h),$B/peers/mujoco)
# the Python package: an interpreter that has what it needs, if there is one; sanitizers cannot be loaded into it
PYTHON  := $(if $(findstring sanitize,$(CFLAGS)),,$(shell for p in python3 /usr/bin/python3; do \
             $$p -c 'from importlib.util import find_spec as f; exit(not (f("cffi") and f("numpy")))' 2>/dev/null && \
             echo $$p && break; done))
PYDEPS   = python3-dev python3-cffi python3-numpy python3-pytest   # optional
SONAME   = liblinkwright.so.$(SO_MAJOR)
OBJCOPY  = objcopy

all: $B/linkwright
MAKEFLAGS += --no-builtin-rules

# ---- building ------------------------------------------------------------------------------------
define KERNEL_RULE
$B/mbs/$(2)/%-$(1).o: mbs/$(2)/%.c
	@mkdir -p $$(@D)
	$$(COMPILE) $$(KERNEL) $$(KERNEL_CFLAGS) -march=$(1) -DLW_ISA=$(subst -,_,$(1)) -DLW_ISA_NAME='"$(1)"' -c $$< -o $$@
endef
$(foreach isa,$(ISAS),$(foreach room,batch ode space,$(eval $(call KERNEL_RULE,$(isa),$(room)))))
# the web pages' style sheets and scripts as C texts, line by line
$B/catalogues/pages/page.o $B/catalogues/pages/atlas_html.o $B/catalogues/pages/space_page.o: $B/catalogues/pages/page_files.h
$B/catalogues/pages/page_files.h: $(wildcard catalogues/pages/*.css catalogues/pages/*.js)
	@mkdir -p $(@D)
	@for f in $^; do echo "__attribute__((unused)) static const char *const lw_$$(basename $$f | tr . _)[] = {"; \
	    sed 's/[\\"]/\\&/g; s/.*/"&\\n",/' $$f; echo 'NULL };'; done > $@
# those of the studio, in a table of names and texts
$B/studio/server.o: $B/studio_files.h
$B/studio_files.h: $(wildcard studio/*.html studio/*.css studio/*.js studio/*.svg)
	@mkdir -p $(@D)
	@n=0; for f in $^; do n=$$((n + 1)); echo "static const char *const studio_file_$$n[] = {"; \
	    sed 's/[\\"]/\\&/g; s/.*/"&\\n",/' $$f; echo 'NULL };'; done > $@
	@n=0; echo 'static const struct { const char *name; const char *const *line; } studio_files[] = {' >> $@; \
	    for f in $^; do n=$$((n + 1)); echo "{ \"$$(basename $$f)\", studio_file_$$n },"; done >> $@; \
	    echo '{ NULL, NULL } };' >> $@
$B/%.o: %.c
	@mkdir -p $(@D)
	$(COMPILE) -c $< -o $@
$B/liblinkwright.a: $(LIB_OBJ)
	rm -f $@; ar rcs $@ $^
# visible: what linkwright.h marks LW_API
$B/$(SONAME): $(LIB_OBJ)
	$(CC) -shared -Wl,-soname,$(SONAME) $(CFLAGS) $(LDFLAGS) $(LIB_OBJ) $(LIBS) -o $@
$B/liblinkwright.so: $B/$(SONAME)
	ln -sf $(SONAME) $@
# the same for those who link it in: one object in which everything else is local
$B/install/liblinkwright.a: $(LIB_OBJ)
	@mkdir -p $(@D)
	rm -f $@; $(LD) -r $(LIB_OBJ) -o $(@:.a=.o) && $(OBJCOPY) --localize-hidden $(@:.a=.o) && ar rcs $@ $(@:.a=.o)
# build-id: a file of --keep is that of one build (cli/program/kept_answers.c)
$B/linkwright: $(CLI_OBJ) $B/liblinkwright.a
	$(CC) $(CFLAGS) $(LDFLAGS) -Wl,--build-id $(PIE) $^ $(PROGRAM_LIBS) -o $@
# the program for tests of limits and faults: the environment sets its clock, its end by a signal, the call that fails, and
# its instruction set
WRAPPED  = malloc calloc realloc aligned_alloc strdup strndup open_memstream fsync rename pthread_create write fflush fclose \
           lw_kernels_supported setitimer dlopen gp_New SUNContext_Create
# with archives calls inside GSL, SUNDIALS and others fail, too
$B/tests/linkwright: $(CLI_OBJ) $B/tests/fake_clock.o $B/tests/kill_at_write.o $B/tests/fail_at_call.o $B/tests/fake_processor.o $B/liblinkwright.a
	$(CC) $(CFLAGS) $(LDFLAGS) -Wl,--build-id -no-pie $(WRAPPED:%=-Wl,--wrap=%) $^ $(ARCHIVES) -o $@
# files of commands that tests call, beside the library
$B/tests/program.a: $(patsubst %.c,$B/%.o,$(wildcard studio/*.c)) $B/cli/bench/flexible_crank.o $B/cli/program/kept_answers.o $B/cli/program/mpi_jobs.o
	rm -f $@; ar rcs $@ $^
# the page in Chromium, where there is one
$B/tests/test_studio_page: tests/browser/studio.sh
	@mkdir -p $(@D)
	@printf '#!/bin/sh\nexec tests/browser/studio.sh "%s"\n' '$B/linkwright' > $@; chmod +x $@
# fresh memory holds NaN (tests/fresh_memory.h)
FRESH_NAN = -Wl,--wrap=malloc
# gold links in half the time
FAST_LINK := $(if $(shell command -v ld.gold),-fuse-ld=gold)
LINK_TEST = $(CC) $(CFLAGS) $(LDFLAGS) $(PIE) $(FAST_LINK) $(FRESH_NAN) $(filter %.o,$^) $(filter %.a,$^) $(LIBS) -o $@
TEST_WITH = $B/tests/check_main.o $B/tests/fuzz/replay.o $B/tests/program.a $B/liblinkwright.a
# `make test` links all tests as one program of as many names (tests/program.h), but for those that define functions of the library
# again, or link what is loaded late
APART    = $(patsubst %,$B/tests/test_%,library_faults dynamics_ggl dynamics_states picture)
TOGETHER = $(filter-out $(APART),$(TESTS))
$B/tests/together/program: $(TOGETHER:=.o) $(TEST_WITH)
	@mkdir -p $(@D)
	$(LINK_TEST)
	@for t in $(notdir $(TOGETHER)); do ln -f $@ $(@D)/$$t || exit 1; done
$(TESTS): %: %.o $(TEST_WITH)
	$(LINK_TEST)
$(BENCHES): %: %.o $B/liblinkwright.a
	$(CC) $(CFLAGS) $(LDFLAGS) $(PIE) $^ $(LIBS) -o $@
$B/docs/examples/%: docs/examples/%.c linkwright.h $B/liblinkwright.so
	@mkdir -p $(@D)
	$(CC) -std=c17 -D_GNU_SOURCE $(WARN) -I. $(CPPFLAGS) $(CFLAGS) $(LDFLAGS) $< -L$B -llinkwright -Wl,-rpath,$(abspath $B) -lm -o $@
# `make python`: the package in $B/python, ready for PYTHONPATH
$B/python/compiled: python/build_c.py linkwright.h $B/liblinkwright.so
	@mkdir -p $(@D)
	LINKWRIGHT_LINK="-L$(abspath $B) -llinkwright -Wl,-rpath,$(abspath $B)" $(PYTHON) python/build_c.py $(@D)
	@touch $@
$B/tests/test_python: $(if $(PYTHON),$B/python/compiled) python/tests/run.sh $(wildcard python/linkwright/*.py)
	@mkdir -p $(@D) $B/python/linkwright
	@cp python/linkwright/* $B/python/linkwright/
	@printf '#!/bin/sh\nexec python/tests/run.sh "%s" "%s"\n' '$(PYTHON)' '$(abspath $B)/python' > $@; chmod +x $@
python: $B/tests/test_python
	@[ -n "$(PYTHON)" ] || { echo "no Python with cffi and numpy: make deps-python installs it"; exit 1; }

notebooks: python            # docs/notebooks from python/notebooks; needs jupyter-nbconvert, python3-ipykernel, python3-matplotlib
	@for n in python/notebooks/*.ipynb; do PYTHONPATH=$(abspath $B)/python $(PYTHON) -m nbconvert --log-level WARN --to markdown \
	    --execute --output-dir docs/notebooks $$n || exit 1; done

$B/peers/simbody: tests/bench/peer_simbody.cc tests/bench/peer.h
	@mkdir -p $(@D)
	g++ -std=c++17 -O3 -g -Wall -Wextra -I. $$(pkg-config --cflags-only-I simbody | sed 's/-I/-isystem/') $< $(SIMBODY) -o $@
$B/peers/mujoco: tests/bench/peer_mujoco.c tests/bench/peer.h
	@mkdir -p $(@D)
	$(CC) -std=c17 -D_GNU_SOURCE $(WARN) -O3 -g -I. $< -lmujoco -lm -o $@
peers: $(PEER_BIN)

# ---- test and demo also install what is missing; pkg-config is asked when make starts, hence twice
JOBS = $(if $(findstring jobserver,$(MAKEFLAGS)),,-j$(shell nproc))
deps:
	@.ci/deps $(DEPS)
deps-bench:
	@.ci/deps $(DEPS) $(PEERS)
deps-python:
	@.ci/deps $(DEPS) $(PYDEPS)
# the kernels need no package: where there is a compiler, they are compiled while packages are installed
HAS_CC    = $(shell $(CC) -include math.h -fsyntax-only -xc /dev/null 2>/dev/null && echo yes)
test demo:
	@$(MAKE) --no-print-directory $(JOBS) deps $(if $(HAS_CC),$(HOT_OBJ))
	@$(MAKE) --no-print-directory $(JOBS) run-$@
shared: $B/liblinkwright.so
samples: $(SAMPLES)                # each checks its own result
	@for s in $(SAMPLES); do $$s > $B/sample.out 2>&1 || { cat $B/sample.out; echo "$$s failed"; exit 1; }; done
PROGRAMS = $(patsubst %,$B/tests/together/%,$(notdir $(TOGETHER))) $(APART) $B/tests/test_python $B/tests/test_studio_page
run-test: $B/linkwright $B/tests/linkwright $B/tests/together/program $(APART) $B/tests/test_python $B/tests/test_studio_page samples
	@LW_PROGRAM=$B/linkwright tests/run.sh $(LONGEST) $(filter-out $(LONGEST),$(PROGRAMS))
# first, so that the last ones end together, not one alone; that of the page waits most of its time
LONGEST  = $(foreach t,studio_page python cli_faults cli_promises cli_fit cli_documents library_faults staged_search fit cli_search \
           cli_atlas cli_same_bits surface cli_catalogue cli_freedoms cli_enumerate topology_search exact_nine elastic_space dynamics_large cli_convert,$(filter %/test_$t,$(PROGRAMS)))
pictures: $B/linkwright            # those of README.md
	$B/linkwright fit examples/walking-foot.csv --crank-only --length-range 5:150 --min-transmission-angle 30 \
	    --results 1 --quiet --json -o $B/foot.json
	$B/linkwright draw $B/foot.json --target examples/walking-foot.csv --size 480x400 \
	    --title "four-bar, fitted to 24 points" -o docs/pictures/foot.svg
	$B/linkwright draw examples/jansen.json --size 480x400 -o docs/pictures/leg.svg
	$B/linkwright chains --links 8 | $B/linkwright draw --grid 8x2 --caption none --size 960x280 \
	    -o docs/pictures/eight.svg
	@mkdir -p docs/pictures/gallery
	for f in examples/gallery/[!i]*.json; do $B/linkwright draw $$f --size 300x240 --force -o docs/pictures/gallery/$$(basename $$f .json).svg || exit 1; done
run-demo: $B/linkwright
	@mkdir -p $B/demo
	$B/linkwright fit examples/*.csv --type all --results 5 --save $B/demo

# ---- looking after it ----------------------------------------------------------------------------
check: $B/$(SONAME) $B/linkwright
	tests/check_layers.sh
	@tests/check_docs.sh $B/linkwright
	@find $(STAGES) cli studio -name '*.h' ! -name 'kernel_*' | sed 's/.*/#include "&"/' > $B/headers.c
	@gcc -std=c17 -D_GNU_SOURCE -I. $(INCS) -fsyntax-only -aux-info $B/declared $B/headers.c
	@nm -A -P --defined-only $(LIB_OBJ) $(CLI_OBJ) | sed -nE 's|^$B/(.*)/[^/]*: (.*) T .*|\2 \1|p' > $B/defined
	@! sed -nE 's|^/\* (\./)?([a-z][^:]*)/([^/:]*):[0-9]*:NC \*/ extern [^(]*[ *]([a-z0-9_]+) \(.*|\4 \2 \3|p' $B/declared | \
	    awk 'NR == FNR { home[$$1] = $$2; next } $$1 in home && home[$$1] != $$2 { print $$2 "/" $$3 " declares " $$1 ", which " home[$$1] " defines" }' $B/defined - | grep .
	@tests/check_headers.sh -D_GNU_SOURCE -DLW_VERSION='""' -I. $(INCS) -Wall -Wextra
	@for f in $(wildcard $(STAGES:%=%/*.c) $(STAGES:%=%/*/*.c) cli/*.c cli/*/*.c studio/*.c tests/*.c tests/*/*.c); do \
	    case "$$f $(PEER_BIN)" in */peer_mujoco.c*peers/mujoco*) ;; */peer_mujoco.c*) continue ;; esac; \
	    clang -std=c17 -D_GNU_SOURCE -DLW_VERSION='""' -DLW_ISA=check -DLW_ISA_NAME='""' $(WARN) -Werror -I. $(INCS) -fsyntax-only $$f || exit 1; done
	@nm -D --defined-only $B/$(SONAME) | awk '{ print $$3 }' | LC_ALL=C sort > $B/exported
	@sed -n 's/^LW_API.*[ *]\(lw_[a-z0-9_]*\)(.*/\1/p' linkwright.h | LC_ALL=C sort | diff $B/exported - || \
	    { echo "the shared library shows other names than linkwright.h"; exit 1; }
	@! nm -g --defined-only $B/liblinkwright.a | awk 'NF == 3 && $$3 !~ /^lw_/' | grep .
	@nm -A -P $(LIB_OBJ) $(CLI_OBJ) | awk '$$3 == "U" { user[$$2] = user[$$2] $$1 " " } $$3 ~ /^[TDBR]$$/ { owner[$$2] = $$1 } \
	    END { for (s in user) { n = split(user[s], u, " "); for (i = 1; i <= n && s in owner; i++) print u[i], owner[s] } }' > $B/uses
	@tsort $B/uses > $B/order || { echo "these files use each other in a circle"; exit 1; }
	@sed -E 's|/[^/ ]*( \|$$)|\1|g' $B/uses | tsort > $B/order || { echo "these folders use each other in a circle"; exit 1; }
	@! objdump -d --no-show-raw-insn $B/linkwright | awk '/^[0-9a-f]+ </ { f = $$2 } \
	    match($$0, /(sub +.|lea +-)0x[0-9a-f]+(,%rsp|\(%rsp\),%r11)/) { n = substr($$0, RSTART, RLENGTH); sub(/^.*0x/, "", n); sub(/[^0-9a-f].*/, "", n); \
	    if (length(n) > 4 && length(n) < 9) print f, "takes 0x" n " bytes of stack, more than 64 KB" }' | grep .
	@tests/test_install.sh B=$B CC="$(CC)" CFLAGS="$(CFLAGS)"
# the kernels would take most of the compile time: KERNEL_CFLAGS compiles them without sanitizers
# programs of fixed addresses (-no-pie) start in half the time: the tables of the sanitizers hold a hundred thousand addresses
# -g1: lines in messages; -g takes half as long again to compile
# asan-globals=0: a program starts in 37 ms instead of 126, and the tests start some ten thousand.  The undefined-behaviour sanitizer
# still checks arrays of known size here; `make fuzz` checks all global ones
sanitize:
	$(MAKE) B=$B/san PIE=-no-pie KERNEL_CFLAGS="-O1 -g1 -fno-sanitize=all" \
	    CFLAGS='-O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all --param asan-globals=0 $$(QUICK)' test
# data races: the tests that use threads
THREADED = parallel pool chains mechanisms fit topology_search staged_search curves library successive_halving
sanitize-threads:
	$(MAKE) $(JOBS) B=$B/tsan CFLAGS='-O1 -g1 -fsanitize=thread $$(QUICK)' KERNEL_CFLAGS="-O1 -g1 -fno-sanitize=all" run-threads
run-threads: $(THREADED:%=$B/tests/test_%)
	@tests/run.sh $^
# lines and branches of the library that `make test` reaches, in $B/coverage.txt; needs clang and llvm.  All programs count into
# mapped files (%c): those that end by a signal, too, and none of some ten thousand spends its time at writing counters when it ends
coverage:
	@rm -rf $B/cov/profiles
	$(MAKE) $(JOBS) $(COUNTED) shared
	@failed=0; LLVM_PROFILE_FILE=$(abspath $B/cov/profiles)/%m%c.profraw $(MAKE) $(COUNTED) test || failed=1; \
	tests/coverage.sh $B/cov > $B/coverage.txt && tail -n 8 $B/coverage.txt; exit $$failed
COUNTED  = B=$B/cov CC=clang KERNEL_CFLAGS="-O1 -Wno-pass-failed" CFLAGS='-O1 $$(QUICK) $$(if $$(filter $$(HOT_SRC),$$<),,$(COUNTERS))'
COUNTERS = -fprofile-instr-generate -fcoverage-mapping -mllvm -runtime-counter-relocation -Wno-unused-command-line-argument
browser-test: $B/tests/test_atlas_html $B/linkwright     # the atlas and the studio in Chromium and Firefox; skipped without
	@tests/browser/run.sh $B
	@tests/browser/studio.sh $B/linkwright long
fuzz:      # FUZZ_SECONDS=60 for each target
	$(MAKE) $(JOBS) B=$B/fuzz CC=clang KERNEL_CFLAGS="-O1 -fno-sanitize=all" \
	    CFLAGS="-O1 -g -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all" run-fuzz
run-fuzz: $B/tests/fuzz/replay.o $B/tests/program.a $B/liblinkwright.a $(FUZZ:=.o)
	@for t in $(notdir $(basename $(wildcard tests/fuzz/fuzz_*.c))); do \
	    $(CC) $(CFLAGS) -fsanitize=fuzzer $B/tests/fuzz/$$t.o $B/tests/fuzz/replay.o $(filter %.a,$^) $(LIBS) -o $B/$$t && mkdir -p $B/found/$$t && \
	    $B/$$t -max_total_time=$(or $(FUZZ_SECONDS),20) -artifact_prefix=$B/found/ $B/found/$$t tests/fuzz/corpus/$${t#fuzz_} || exit 1; done
bench: $(BENCHES) $(PEER_BIN) $B/linkwright
	@for b in $(BENCHES); do echo "$$b"; $$b || exit 1; done
	$B/linkwright bench fit -o $B/bench
	$B/linkwright bench mbs -o $B/bench

$B/linkwright.1: docs/linkwright.1.in $B/linkwright
	$B/linkwright help --roff | sed -e 's/@VERSION@/$(VERSION)/; s|@DOCDIR@|$(DOCDIR)|; s|@DATADIR@|$(DATADIR)|' -e '/@COMMANDS@/{r /dev/stdin' -e 'd}' docs/linkwright.1.in > $@
$B/library.md: docs/library.awk linkwright.h
	@mkdir -p $(@D)
	awk -f docs/library.awk linkwright.h linkwright.h > $@
docs: $B/library.md          # the reference of the library as a page
$B/linkwright.bash: $B/linkwright
	$B/linkwright help --completion bash > $@
$B/linkwright.pc: linkwright.pc.in Makefile linkwright.h
	@sed 's|@PREFIX@|$(PREFIX)|; s|@LIBDIR@|$(LIBDIR)|; s|@VERSION@|$(VERSION)|; s|@PKGS@|$(PKGS)|; s|@LIBS@|$(PRIVATE)|' $< > $@

# what is installed: mode, from, to.  Documentation and examples keep the names that texts call them by.
DATA := $(wildcard catalogues/data/*.csv catalogues/data/paths/*.csv catalogues/data/mbs/*) $(wildcard docs/*.schema.json)
DOCS := README.md CHANGELOG.md $(wildcard docs/*.md docs/*.svg docs/*.bib docs/pictures/*.* docs/pictures/gallery/* docs/plots/* docs/data/* docs/notebooks/*.md docs/notebooks/*/* docs/examples/*.c) \
        $(shell find examples -type f)
DATADIR = $(PREFIX)/share/linkwright
DOCDIR  = $(PREFIX)/share/doc/linkwright
define INSTALLED
755 $B/linkwright $(PREFIX)/bin/linkwright
644 linkwright.h $(PREFIX)/include/linkwright.h
755 $B/$(SONAME) $(LIBDIR)/$(SONAME)
644 $B/install/liblinkwright.a $(LIBDIR)/liblinkwright.a
644 $B/linkwright.pc $(LIBDIR)/pkgconfig/linkwright.pc
644 $B/linkwright.1 $(PREFIX)/share/man/man1/linkwright.1
644 $B/library.md $(DOCDIR)/docs/library.md
644 $B/linkwright.bash $(PREFIX)/share/bash-completion/completions/linkwright
$(foreach f,$(DATA),644 $f $(DATADIR)/$(patsubst docs/%,%,$(f:catalogues/data/%=%))\n)
$(foreach f,$(DOCS),644 $f $(DOCDIR)/$f\n)
endef
export INSTALLED
LISTED = printf '%b\n' "$$INSTALLED" | while read -r mode from to; do [ -z "$$to" ] ||

install: all $B/$(SONAME) $B/install/liblinkwright.a $B/linkwright.bash $B/library.md
	@rm -f $B/linkwright.pc $B/linkwright.1; $(MAKE) --no-print-directory $B/linkwright.pc $B/linkwright.1   # they hold PREFIX
	@$(LISTED) install -D -m "$$mode" "$$from" "$(DESTDIR)$$to" || exit 1; done
	@ln -sf $(SONAME) $(DESTDIR)$(LIBDIR)/liblinkwright.so
	@echo "installed in $(DESTDIR)$(PREFIX)"
uninstall:
	@$(LISTED) rm -f "$(DESTDIR)$$to"; done; rm -f $(DESTDIR)$(LIBDIR)/liblinkwright.so
	@for d in $(DATADIR) $(DOCDIR); do [ ! -d $(DESTDIR)$$d ] || find $(DESTDIR)$$d -depth -type d -empty -delete; done

clean:
	rm -rf $B
.PHONY: all docs shared samples python notebooks deps deps-bench deps-python peers test demo pictures run-test run-demo check sanitize sanitize-threads run-threads coverage browser-test fuzz run-fuzz bench install uninstall clean
.PRECIOUS: $B/%.o     # kept between makes; .SECONDARY would skip a new file that is older than the archive
-include $(shell find $B -name '*.d' 2>/dev/null)
