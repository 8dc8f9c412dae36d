/* grammar/topology/joint_kind.h - the kinds of joints and what each of them does.
 *
 * One row a kind.  Rooms ask for a trait ("does it slide?") and name a kind only for an equation, a symbol or a
 * format that belongs to this kind alone. */
#ifndef LW_GRAMMAR_TOPOLOGY_JOINT_KIND_H
#define LW_GRAMMAR_TOPOLOGY_JOINT_KIND_H

#include <stdbool.h>

/* The kind of a joint's coordinate, which counts from the given posture. */
typedef enum lw_joint_measure {
    LW_MEASURE_NONE,     /* no coordinate, and no position that a person must give                 */
    LW_MEASURE_ANGLE,    /* the rotation of the links about a pin at `at`                    [rad] */
    LW_MEASURE_LENGTH    /* the displacement along the slide line through `at` along `along`   [m] */
} lw_joint_measure;

/* Columns: the letter, the constant, a word for people, the degrees of freedom, the coordinate; do the links keep one
 * point at `at` in common; do they keep their angle to each other; does the joint couple two motions by a ratio (see
 * lw_linkage_gear)?
 *
 * The last four columns determine the constraint equations: two for a common point, one for a slide line, one for the
 * angle, one for a ratio.  A weld and a free link stand in linkages only, never in a chain. */
#define LW_JOINT_LIST(X)                                                                   \
    X('r', LW_JOINT_REVOLUTE, "revolute",    1, LW_MEASURE_ANGLE,  true,  false, false)    \
    X('t', LW_JOINT_SLIDER,   "prismatic",   1, LW_MEASURE_LENGTH, false, true,  false)    \
    X('p', LW_JOINT_SLOT,     "pin-in-slot", 2, LW_MEASURE_LENGTH, false, false, false)    \
    X('g', LW_JOINT_GEAR,     "gear",        2, LW_MEASURE_NONE,   false, false, true)     \
    X('f', LW_JOINT_FIXED,    "weld",        0, LW_MEASURE_NONE,   true,  true,  false)    \
    X('n', LW_JOINT_FREE,     "free",        3, LW_MEASURE_NONE,   false, false, false)

typedef enum lw_joint_kind {
#define X(letter, name, word, freedoms, measure, point, turn, ratio) name = letter,
    LW_JOINT_LIST(X)
#undef X
} lw_joint_kind;

/* A function that gives the value of one column of the table; `other` for a letter that is no kind. */
#define LW_JOINT_COLUMN(type, function, column, other)                                     \
    static inline type function(lw_joint_kind kind)                                        \
    {                                                                                      \
        switch (kind) { LW_JOINT_LIST(column) }                                            \
        return other;                                                                      \
    }
#define LW_JOINT_WORD(letter, name, word, freedoms, measure, point, turn, ratio)     case name: return word;
#define LW_JOINT_FREEDOMS(letter, name, word, freedoms, measure, point, turn, ratio) case name: return freedoms;
#define LW_JOINT_MEASURE(letter, name, word, freedoms, measure, point, turn, ratio)  case name: return measure;
#define LW_JOINT_POINT(letter, name, word, freedoms, measure, point, turn, ratio)    case name: return point;
#define LW_JOINT_TURN(letter, name, word, freedoms, measure, point, turn, ratio)     case name: return turn;
#define LW_JOINT_RATIO(letter, name, word, freedoms, measure, point, turn, ratio)    case name: return ratio;

LW_JOINT_COLUMN(const char *, lw_joint_word, LW_JOINT_WORD, "")
LW_JOINT_COLUMN(int, lw_joint_freedoms, LW_JOINT_FREEDOMS, 0)
LW_JOINT_COLUMN(lw_joint_measure, lw_joint_measure_of, LW_JOINT_MEASURE, LW_MEASURE_NONE)
LW_JOINT_COLUMN(bool, lw_joint_holds_point, LW_JOINT_POINT, false)
LW_JOINT_COLUMN(bool, lw_joint_holds_rotation, LW_JOINT_TURN, false)
LW_JOINT_COLUMN(bool, lw_joint_has_ratio, LW_JOINT_RATIO, false)

/* Number of constraint equations: 3 less the degrees of freedom. */
static inline int lw_joint_equations(lw_joint_kind kind) { return 3 - lw_joint_freedoms(kind); }

/* Is it a pin, whose coordinate is an angle?  Does it have a slide line, along which its coordinate is a length? */
static inline bool lw_joint_turns(lw_joint_kind kind)  { return lw_joint_measure_of(kind) == LW_MEASURE_ANGLE; }
static inline bool lw_joint_slides(lw_joint_kind kind) { return lw_joint_measure_of(kind) == LW_MEASURE_LENGTH; }

/* A slide line: do both links carry it (a block on a rail), or does a pin of link[1] move in a slot of link[0]? */
static inline bool lw_joint_translates(lw_joint_kind kind)
{
    return lw_joint_slides(kind) && lw_joint_holds_rotation(kind);
}
static inline bool lw_joint_has_slot(lw_joint_kind kind)
{
    return lw_joint_slides(kind) && !lw_joint_holds_rotation(kind);
}

/* Does it have a position of its own?  That of a gear follows from its links, that of a weld does not matter. */
static inline bool lw_joint_has_position(lw_joint_kind kind) { return lw_joint_measure_of(kind) != LW_MEASURE_NONE; }

/* Can it be an input, have stops, and be counted by q() and v()? */
static inline bool lw_joint_can_drive(lw_joint_kind kind) { return lw_joint_freedoms(kind) == 1; }

static inline bool lw_joint_is_kind(char letter) { return *lw_joint_word((lw_joint_kind)letter) != '\0'; }

#endif
