/* catalogues/store/store_schema.c - the tables of a catalogue, version by version; docs/catalogue.md explains them. */
#include "catalogues/store/store_internal.h"

/* A version that was released is never changed: add a new step instead. */
static const char version_1[] =
    "CREATE TABLE run( id INTEGER PRIMARY KEY, action TEXT NOT NULL, what TEXT NOT NULL, program TEXT NOT NULL, seed TEXT NOT NULL,"
    " command TEXT NOT NULL, units TEXT NOT NULL, begun TEXT NOT NULL, ended TEXT);CREATE TABLE build("
    " id INTEGER PRIMARY KEY, links INTEGER NOT NULL, dof INTEGER NOT NULL, joints TEXT NOT NULL,"
    " done INTEGER NOT NULL DEFAULT 0, complete INTEGER NOT NULL DEFAULT 0, UNIQUE(links, dof, joints));CREATE TABLE structure("
    " id INTEGER PRIMARY KEY, loops INTEGER NOT NULL, number INTEGER NOT NULL, circles INTEGER NOT NULL,"
    " lines INTEGER NOT NULL, planar INTEGER NOT NULL, form TEXT NOT NULL UNIQUE, derivation TEXT NOT NULL,"
    " run INTEGER NOT NULL REFERENCES run(id), UNIQUE(loops, number));CREATE TABLE chain("
    " id INTEGER PRIMARY KEY, label TEXT NOT NULL UNIQUE, graph6 TEXT NOT NULL, links INTEGER NOT NULL,"
    " dof INTEGER NOT NULL, joints INTEGER NOT NULL, loops INTEGER NOT NULL, structure INTEGER REFERENCES structure(id),"
    " assortment TEXT NOT NULL, binary INTEGER NOT NULL, ternary INTEGER NOT NULL, quaternary INTEGER NOT NULL,"
    " quinary INTEGER NOT NULL, senary INTEGER NOT NULL, symmetry INTEGER NOT NULL, grounds INTEGER NOT NULL,"
    " planar INTEGER NOT NULL, franke TEXT NOT NULL, sentence TEXT NOT NULL, matrix TEXT NOT NULL, layout BLOB,"
    " run INTEGER NOT NULL REFERENCES run(id));CREATE INDEX chain_links ON chain(links, dof);CREATE TABLE ground("
    " chain INTEGER NOT NULL REFERENCES chain(id), link INTEGER NOT NULL, alike INTEGER NOT NULL, PRIMARY KEY(chain, link)) WITHOUT ROWID;"
    "CREATE TABLE mechanism( id INTEGER PRIMARY KEY, chain INTEGER NOT NULL REFERENCES chain(id), ground INTEGER NOT NULL,"
    " kinds TEXT NOT NULL, sliders INTEGER NOT NULL, inputs TEXT NOT NULL, assur TEXT NOT NULL,"
    " groups_n INTEGER NOT NULL, highest INTEGER NOT NULL, modes INTEGER, run INTEGER NOT NULL REFERENCES run(id),"
    " UNIQUE(chain, ground, kinds, inputs));";

/* Curves and results of fits. */
static const char version_2[] =
    "CREATE TABLE sweep( id INTEGER PRIMARY KEY, families TEXT NOT NULL, kinds INTEGER NOT NULL, seed TEXT NOT NULL,"
    " samples INTEGER NOT NULL DEFAULT 0, segments INTEGER NOT NULL DEFAULT 0, UNIQUE(families, kinds, seed));CREATE TABLE curve_segment("
    " id INTEGER PRIMARY KEY, sweep INTEGER NOT NULL REFERENCES sweep(id), number INTEGER NOT NULL,"
    " closed INTEGER NOT NULL, n INTEGER NOT NULL, first_block INTEGER NOT NULL, boxes BLOB NOT NULL,"
    " run INTEGER NOT NULL REFERENCES run(id), UNIQUE(sweep, number, closed));"
    "CREATE TABLE curve_block(id INTEGER PRIMARY KEY, terms BLOB NOT NULL, linkages BLOB NOT NULL);CREATE TABLE linkage("
    " id INTEGER PRIMARY KEY, hash TEXT NOT NULL UNIQUE, name TEXT NOT NULL, links INTEGER NOT NULL,"
    " dof INTEGER NOT NULL, joints INTEGER NOT NULL, sliders INTEGER NOT NULL, kinds TEXT NOT NULL, label TEXT,"
    " type TEXT, family TEXT, class TEXT, task TEXT, timing TEXT, target TEXT, source TEXT,"
    " objective REAL, error REAL, error_mean REAL, error_rms REAL, error_max REAL, error_curve REAL, angle_error REAL,"
    " crank INTEGER, circuits INTEGER, transmission_min REAL, transmission_max REAL, size REAL, closed INTEGER,"
    " curve BLOB, terms BLOB, json TEXT NOT NULL, run INTEGER NOT NULL REFERENCES run(id));CREATE INDEX linkage_label ON linkage(label);"
    "CREATE INDEX linkage_error ON linkage(error);";

/* Parts of drives, in SI units; 0: not given. */
static const char version_3[] =
    "CREATE TABLE motor( id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, torque_constant REAL NOT NULL, resistance REAL NOT NULL,"
    " inductance REAL NOT NULL, inertia REAL NOT NULL, torque REAL NOT NULL, torque_peak REAL NOT NULL, speed REAL NOT NULL,"
    " mass REAL NOT NULL, price REAL NOT NULL, run INTEGER NOT NULL REFERENCES run(id));CREATE TABLE gear("
    " id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, ratio REAL NOT NULL, radius REAL NOT NULL,"
    " efficiency REAL NOT NULL, inertia REAL NOT NULL, torque REAL NOT NULL, torque_peak REAL NOT NULL, speed REAL NOT NULL,"
    " mass REAL NOT NULL, price REAL NOT NULL, run INTEGER NOT NULL REFERENCES run(id));CREATE TABLE amplifier("
    " id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, voltage REAL NOT NULL, current REAL NOT NULL,"
    " current_peak REAL NOT NULL, peak_time REAL NOT NULL, mass REAL NOT NULL, price REAL NOT NULL,"
    " run INTEGER NOT NULL REFERENCES run(id));";

/* Parts of a sequence of curves: number of segments before those in the file. */
static const char version_4[] = "ALTER TABLE sweep ADD COLUMN first INTEGER NOT NULL DEFAULT 0;";

/* Chains with multiple joints. */
static const char version_5[] =
    "CREATE TABLE multiple( id INTEGER PRIMARY KEY, pins TEXT NOT NULL UNIQUE, links INTEGER NOT NULL, dof INTEGER NOT NULL,"
    " joints INTEGER NOT NULL, loops INTEGER NOT NULL, assortment TEXT NOT NULL, symmetry INTEGER NOT NULL,"
    " planar INTEGER NOT NULL, grounds INTEGER NOT NULL, ground_links TEXT NOT NULL, run INTEGER NOT NULL REFERENCES run(id));";

const char *const lw_store_steps[] = { version_1, version_2, version_3, version_4, version_5 };
const int lw_store_step_count = sizeof lw_store_steps/sizeof *lw_store_steps;
