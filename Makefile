# linkwright: make, make test, make demo, make bench, make check, make install.  See README.md.
VERSION  = 0.1.0
SO_MAJOR = 0
B        = build
CC       = gcc
CFLAGS   = -O3 -g
PREFIX   = /usr/local
STAGES   = base grammar enumerate mbs optimise catalogues     # each includes only those before it

PKGS     = gsl nlopt jansson cairo
WARN     = -Wall -Wextra -Wpedantic -Wshadow -Wstrict-prototypes -Wmissing-prototypes -Wvla -Wno-unknown-pragmas
# contraction off: the same bits on every processor; no errno, no trap flags: sqrt vectorises
FLOAT    = -ffp-contract=off -fno-math-errno -fno-trapping-math
INCS    := $(shell pkg-config --cflags $(PKGS) 2>/dev/null)
LIBS    := $(shell pkg-config --libs $(PKGS) 2>/dev/null) -lplanarity -lgif -lpthread -lm
COMPILE  = $(CC) -std=c17 -D_GNU_SOURCE -DLW_VERSION='"$(VERSION)"' $(WARN) $(FLOAT) -fPIC -I. $(INCS) $(CFLAGS) -MMD -MP

# mbs/kernel.c holds the hot loops; it is compiled once per instruction set and chosen at run time
ISAS    := $(if $(filter x86_64,$(shell uname -m)),x86-64 x86-64-v3 x86-64-v4,native)
LIB_SRC := $(filter-out mbs/kernel.c,$(wildcard $(STAGES:%=%/*.c)))
LIB_OBJ := $(LIB_SRC:%.c=$B/%.o) $(if $(wildcard mbs/kernel.c),$(ISAS:%=$B/mbs/kernel-%.o))
CLI_OBJ := $(patsubst %.c,$B/%.o,$(wildcard cli/*.c))
TESTS   := $(patsubst %.c,$B/%,$(wildcard tests/test_*.c))

all: $B/linkwright

$B/mbs/kernel-%.o: mbs/kernel.c
	@mkdir -p $(@D)
	$(COMPILE) -march=$* -mprefer-vector-width=512 -DLW_ISA=$(subst -,_,$*) -DLW_ISA_NAME='"$*"' -c $< -o $@
$B/%.o: %.c
	@mkdir -p $(@D)
	$(COMPILE) -c $< -o $@
$B/liblinkwright.a: $(LIB_OBJ)
	rm -f $@; ar rcs $@ $^
$B/linkwright: $(CLI_OBJ) $B/liblinkwright.a
	$(CC) $(CFLAGS) $(LDFLAGS) $^ $(LIBS) -o $@
$B/tests/%: $B/tests/%.o $B/liblinkwright.a
	$(CC) $(CFLAGS) $(LDFLAGS) $^ $(LIBS) -o $@

test: $B/linkwright $(TESTS)
	@for t in $(TESTS); do LW_PROGRAM=$B/linkwright $$t || exit 1; done

clean:
	rm -rf $B
.PHONY: all test clean
.SECONDARY:
-include $(shell find $B -name '*.d' 2>/dev/null)
