/* Shares of the rounds: every family has its turn, the cheap ones before the dear ones, the better ones more. */
#include "optimise/search/fit_internal.h"
#include "tests/check.h"

/* Every seventh family is worked out by groups where `dear` says so, the last three are starts. */
typedef struct crowd { int n; bool dear; } crowd;

static lw_turn turn_of(const void *of, int i)
{
    const crowd *c = of;
    return i >= c->n - 3 ? LW_TURN_START : c->dear && i % 7 == 0 ? LW_TURN_GROUPS : LW_TURN_DYADS;
}

static double worth(int candidate) { return 1 + candidate*2654435761u % 100003; }

/* A find of the candidate with this f. */
static lw_best_starts *find_of(int candidate, double f)
{
    static lw_pool pool;
    lw_variables v = { .n = 1 };
    pool.n = 0;
    lw_found c = { .f = f, .candidate = candidate };
    lw_pool_put(&pool, &c, &v);
    return lw_best_starts_of(&pool, 1, &v, 0);
}

static lw_search *begin(crowd *c, lw_families *f, lw_fit_options *o)
{
    lw_search *s = calloc(1, sizeof *s);
    *f = (lw_families){ c->n, NULL, turn_of, c };
    *o = (lw_fit_options){ .families = f, .seed = 1, .sweep = o->sweep };
    s->o = o;
    s->n_candidate = c->n;
    s->candidate = calloc((size_t)c->n + 1, sizeof *s->candidate);
    CHECK_INT(lw_search_halving_begin(s), LW_OK);
    return s;
}

static void end(lw_search *s)
{
    for (int i = 0; i < s->n_candidate; i++)
        free(s->candidate[i].best);
    free(s->candidate);
    free(s->sweep.order);
    free(s->sweep.candidate);
    free(s);
}

/* What the jobs of a round would find. */
static void learn(lw_search *s)
{
    for (int j = 0; j < s->n_job; j++) {
        lw_search_candidate *a = &s->candidate[s->job[j].candidate];
        a->state = LW_FIT_CLOSED;
        a->starts++;
        if (!a->best)
            a->best = find_of(s->job[j].candidate, worth(s->job[j].candidate));
    }
}

static bool in_round(const lw_search *s, int candidate)
{
    for (int j = 0; j < s->n_job; j++)
        if (s->job[j].candidate == candidate)
            return true;
    return false;
}

TEST(few_families_are_all_looked_at)
{
    crowd c = { .n = 20 };
    lw_families f;
    lw_fit_options o = { 0 };
    lw_search *s = begin(&c, &f, &o);
    lw_search_halving(s);
    for (int i = 0; i < c.n; i++)
        CHECK(in_round(s, i));
    for (int left = 10; left >= 3; left = (left + 1)/2) {            /* the better half each time            */
        learn(s);
        lw_search_halving(s);
        for (int i = 0; i < c.n; i++) {
            int better = 0;
            for (int k = 0; k < c.n; k++)
                better += worth(k) < worth(i);
            CHECK_INT(in_round(s, i), better < left);
        }
    }
    learn(s);
    lw_search_halving(s);                                              /* and all over again                   */
    for (int i = 0; i < c.n; i++)
        CHECK(in_round(s, i));
    end(s);
}

/* From a near miss a valley may lead to the exact find, or from another start: both are searched. */
TEST(beside_a_near_miss_other_starts_are_drawn)
{
    crowd c = { .n = 20 };
    lw_families f;
    lw_fit_options o = { 0 };
    lw_search *s = begin(&c, &f, &o);
    int near = 0, other = 0, drawn = 0;
    s->candidate[7].best = find_of(7, 1e-12);
    for (int round = 0; round < 8; round++) {
        lw_search_halving(s);
        for (int j = 0; j < s->n_job; j++) {
            near += s->job[j].around && s->job[j].candidate == 7;
            other += s->job[j].around && s->job[j].candidate != 7;
            drawn += !s->job[j].around && s->job[j].candidate == 7;
        }
        learn(s);
    }
    CHECK(near > 0 && other > 0 && drawn >= 8);
    end(s);
}

/* Of thousands each has its turn before any has two first looks; starts come first, groups last and by themselves.  Sweeps
 * that a round has no room to widen do not halve more than they look at. */
TEST(many_families_have_their_turn)
{
    static const long sweep[] = { 0, 20000 };
    for (int trial = 0; trial < 2; trial++) {
        crowd c = { .n = trial ? 1500 : 20000, .dear = true };
        lw_families f;
        lw_fit_options o = { .sweep = sweep[trial] };
        lw_search *s = begin(&c, &f, &o);
        int looked = 0, halved = 0, rounds = 0, *seen = calloc((size_t)c.n, sizeof *seen);
        lw_turn last = LW_TURN_START;
        for (; looked < c.n && rounds < 400; rounds++) {
            lw_search_halving(s);
            CHECK(s->n_job > 0 && s->n_job <= LW_JOB_MAX);
            halved += s->sweep.rung > 0 ? s->n_job : 0;
            for (int j = 0; j < s->n_job && s->sweep.rung == 0; j++) {
                int candidate = s->job[j].candidate, fresh = !seen[candidate];
                lw_turn turn = turn_of(&c, candidate);
                CHECK(fresh && !s->job[j].around);
                CHECK(turn == LW_TURN_START || turn >= last);
                CHECK((turn == LW_TURN_GROUPS) == (turn_of(&c, s->job[0].candidate) == LW_TURN_GROUPS));
                CHECK(turn != LW_TURN_START || rounds == 0);
                last = turn == LW_TURN_START ? last : turn;
                seen[candidate] = 1;
                looked += fresh;
            }
            learn(s);
        }
        CHECK_INT(looked, c.n);
        CHECK(trial == 1 || halved <= looked);
        free(seen);
        end(s);
    }
}

/* Among families of dyads one with groups has a job when the others have had as many evaluations. */
TEST(groups_have_as_many_evaluations_as_others)
{
    crowd c = { .n = 43, .dear = true };                               /* 6 with groups, of which no start          */
    lw_families f;
    lw_fit_options o = { 0 };
    lw_search *s = begin(&c, &f, &o);
    CHECK(s->sweep.apart);
    end(s);
    c.n = 12;                                                          /* 2 with groups: still too dear             */
    s = begin(&c, &f, &o);
    CHECK(s->sweep.apart);
    s->sweep.apart = false;
    int jobs[12] = { 0 };
    for (int round = 0; round < 3; round++) {
        lw_search_halving(s);
        for (int j = 0; j < s->n_job; j++)
            jobs[s->job[j].candidate]++;
        learn(s);
    }
    for (int i = 0; i < c.n; i += 7)
        CHECK(jobs[i] > 0 && jobs[i] <= 4);                            /* of 8 or more rounds of jobs                */
    end(s);
}

/* Those that cannot do the task take no part; when none is left there is nothing to do. */
TEST(the_unable_are_left_out)
{
    crowd c = { .n = 60, .dear = true };
    lw_families f;
    lw_fit_options o = { 0 };
    lw_search *s = begin(&c, &f, &o);
    for (int i = 0; i < c.n; i++)
        s->candidate[i].state = i % 2 ? LW_FIT_UNABLE : LW_FIT_UNREACHED;
    for (int round = 0; round < 12; round++) {
        lw_search_halving(s);
        CHECK(s->n_job > 0);
        for (int j = 0; j < s->n_job; j++)
            CHECK(s->job[j].candidate % 2 == 0);
        learn(s);
    }
    for (int i = 0; i < c.n; i++)
        s->candidate[i].state = LW_FIT_UNABLE;
    lw_search_halving(s);
    CHECK_INT(s->n_job, 0);
    end(s);
    c.n = 0;
    s = begin(&c, &f, &o);
    lw_search_halving(s);
    CHECK_INT(s->n_job, 0);
    end(s);
}
