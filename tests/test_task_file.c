/* Tasks: what they say, what is refused and where, dwells as stations. */
#include "optimise/task/task_file.h"
#include "tests/json_text.h"

static lw_status read(const char *text, lw_task_file *b, lw_error *e)
{
    *e = (lw_error){ .text = "" };
    FREED char *json = json_quotes(strdup(text));
    lw_status s = lw_task_file_read(json, strlen(json), "t.json", b, e);
    return s;
}

TEST(everything_is_read)
{
    static const char text[] =
        "{'linkwright-task':1,'name':'n','units':{'length':'mm','angle':'deg'},'target':'p.csv',"
        "'closed':true,'task':'motion','timing':'free','links':6,'joints':'r,t','topology':'watt1',"
        "'crank':true,'weights':{'path':2,'angle':3},'transmission':30,'acceleration':4,"
        "'lengths':{'least':5,'most':50,'ratio':6},'positions':{'least':-7,'most':8},'pivots':{'line':[[1,1],[1,3]],'within':0.5},"
        "'forbidden':[{'circle':[[9,8],2]},{'box':[[20,30],[40,50]]}],"
        "'max_size':3,'class_margin':0,'through_limits':true,'tolerance':0.2,'smooth':1.5,'resample':40}";
    OWN(lw_task_file) b = { 0 };
    CHECK_OK(read(text, &b, &check_error));
    CHECK_TEXT(b.name, "n");
    CHECK_TEXT(b.target, "p.csv");
    CHECK_TEXT(b.topology, "watt1");
    CHECK(b.closed == 1 && b.links == 6 && b.has_task && b.has_timing && b.spec.crank_only);
    CHECK_INT(b.spec.task, LW_TASK_MOTION);
    CHECK_INT(b.spec.timing, LW_TIMING_FREE);
    CHECK_NEAR(b.spec.a, 2e6, 0, 1e-14);
    CHECK_NEAR(b.spec.b, 3, 0, 0);
    CHECK_NEAR(b.spec.min_transmission, LW_PI/6, 0, 1e-15);
    CHECK_NEAR(b.spec.max_acceleration, 4e-3, 0, 1e-15);
    CHECK_NEAR(b.spec.length_lo, 5e-3, 0, 1e-15);
    CHECK_NEAR(b.spec.length_hi, 5e-2, 0, 1e-15);
    CHECK_NEAR(b.spec.length_ratio, 6, 0, 0);
    CHECK_NEAR(b.spec.position_lo, -7e-3, 0, 1e-15);
    CHECK_NEAR(b.spec.max_size, 3, 0, 0);
    CHECK_NEAR(b.spec.tolerance, 2e-4, 0, 1e-14);
    CHECK_NEAR(b.smooth, 1.5, 0, 0);
    CHECK_INT(b.resample, 40);
    CHECK_INT(b.limits, LW_LIMIT_ALL);                  /* transmission, ratio, size, margin 0, through limits  */
    CHECK_INT(b.spec.n_zone, 3);
    CHECK_INT(b.spec.zone[0].kind, LW_ZONE_PIVOTS_LINE);
    CHECK_NEAR(b.spec.zone[0].to.y, 1, 1e-15, 0);
    CHECK_NEAR(b.spec.zone[0].reach, 5e-4, 0, 1e-14);
    CHECK_INT(b.spec.zone[1].kind, LW_ZONE_NO_CIRCLE);
    CHECK_NEAR(b.spec.zone[1].reach, 2e-3, 0, 1e-15);
    CHECK_NEAR(b.spec.zone[2].to.x, 0.04, 0, 1e-15);
}

TEST(faults_have_a_place)
{
    static const struct { const char *text; long line, column; const char *says; } bad[] = {
        { "{'linkwright-task':2,'target':'a'}", 1, 20, "version 2" },
        { "{'linkwright-task':1}", 1, 1, "is missing" },
        { "{'linkwright-task':1,'target':'a',\n'timming':'free'}", 2, 1, "timing" },
        { "{'linkwright-task':1,'target':'a','timing':'fre'}", 1, 44, "free" },
        { "{'linkwright-task':1,'target':'a','lengths':{'least':5,'most':4}}", 1, 45, "no linkage can do both" },
        { "{'linkwright-task':1,'target':'a','resample':2.5}", 1, 46, "whole number" },
        { "{'linkwright-task':1,'stations':[{'x':1,'y':2}],'smooth':1}", 1, 58, "names none" },
        { "{'linkwright-task':1,'target':'a','unlimited':true,'tolerance':1}", 1, 64, "unlimited" },
        { "{'linkwright-task':1,'target':'a','links':5}", 1, 43, "4, 6, 8 or 10" },
        { "{'linkwright-task':1,'target':'a','dof':2,'links':6}", 1, 51, "5, 7 or 9 links" },
        { "{'linkwright-task':1,'target':'a','dof':4}", 1, 41, "3" },
        { "{'linkwright-task':1,'target':'a','transmission':2}", 1, 50, "between" },
        { "{'linkwright-task':1,'target':'a','pivots':{'box':[[1,1],[0,2]]}}", 1, 51, "holds nothing" },
        { "{'linkwright-task':1,'target':'a','forbidden':[{'polygon':[[0,0],[4,0],[2,1],[2,4]]}]}", 1, 59, "corner 3" },
        { "{'linkwright-task':1,'target':'a','forbidden':[{'polygon':[[0,0],[2,4],[2,1],[4,0]]}]}", 1, 59, "corner 3" },
        { "{'linkwright-task':1,'target':'a','forbidden':[{'polygon':[[0,0],[4,3],[0,4],[5,1],[3,5]]}]}", 1, 59, "" },
        { "{'linkwright-task':1,'target':'a','forbidden':[{'polygon':[[0,0],[4,0]]}]}", 1, 59, "3" },
        { "{'linkwright-task':1,'target':'a','pivots':{'box':[[0,0],[1,1]]},'forbidden':"
          "[{'polygon':[[-1,-1],[-1,3],[3,3],[3,-1]]}]}", 1, 78, "whole box" },
        { "{'linkwright-task':1,'target':'a','pivots':{'box':[[0,0],[1,1]]},'forbidden':[{'circle':[[0,0],2]}]}", 1, 78, "no linkage can do both" },
        { "{'linkwright-task':1,'target':'a','pivots':{'box':[[0,0],[2,1]]},'forbidden':"
          "[{'box':[[-1,-1],[1.2,2]]},{'circle':[[1.6,0.5],0.8]}]}", 1, 78, "whole box" },
        { "{'linkwright-task':1,'target':'a','pivots':{'box':[[5,0],[6,1]]},'positions':{'least':0,'most':4}}",
          1, 44, "range of positions" },
        { "{'linkwright-task':1,'target':'a','pivots':{'line':[[0,9],[9,0]]},'positions':{'least':0,'most':4}}",
          1, 44, "range of positions" },
        { "{'linkwright-task':1,'target':'a','dwell':[{'from':2,'to':1}]}", 1, 44, "smaller to a greater" },
        { "{'linkwright-task':1,'target':'a','dwell':[{'from':1,'to':2},{'from':2,'to':3}]}", 1, 62,
          "rest at two places" },
        { "{'linkwright-task':1,'stations':[{'x':1,'y':1},{'x':1}]}", 1, 48, "missing" },
        { "{'linkwright-task':1,'crank':1,'target':'a'}", 1, 30, "true or false" },
        { "{'linkwright-task':1,'tracers':[{'target':'a'},{'link':'coupler'}]}", 1, 48, "is missing" },
        { "{'linkwright-task':1,'target':'a','tracers':[{'target':'b'}]}", 1, 31, "not both" },
        { "{'linkwright-task':1,'tracers':[{'target':'a','link':'input'}]}", 1, 54, "for the further ones" },
        { "{'linkwright-task':1,'tracers':[{'target':'a'},{'target':'b','link':'cuopler'}]}", 1, 69, "coupler" },
        { "{'linkwright-task':1,'stations':[{'x':1,'y':1,'x3':1,'y3':2},{'x':2,'y':1,'x3':1,'y3':2}]}", 1, 33,
          "numbered without gaps" },
        { "{'linkwright-task':1,'stations':[{'x':1,'y':1,'x2':1},{'x':2,'y':1,'x2':1}]}", 1, 33, "point 2 needs x and y" },
        { "{'linkwright-task':1,'target':'a','point_links':['rocker']}", 1, 50, "no link \"rocker\"" },
    };
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++) {
        lw_task_file b;
        lw_error e;
        CHECK_INT(read(bad[i].text, &b, &e), LW_E_NOTATION);
        CHECK_INT(e.line, bad[i].line);
        CHECK_INT(e.column, bad[i].column);
        CHECK_HAS(e.text, bad[i].says);
    }
}

/* What only seems to contradict is read: zones that leave a corner of the box, a line through one of the range. */
TEST(what_can_be_done_is_no_contradiction)
{
    static const char *const good[] = {
        "{'linkwright-task':1,'target':'a','pivots':{'box':[[0,0],[2,1]]},'forbidden':[{'box':[[-1,-1],[1.2,2]]},{'circle':[[1.6,0.5],0.6]}]}",
        "{'linkwright-task':1,'target':'a','pivots':{'box':[[0,0],[2,1]]},'forbidden':[{'box':[[-1,-1],[0.9,2]]},{'box':[[1,-1],[3,2]]}]}",
        "{'linkwright-task':1,'target':'a','pivots':{'line':[[0,7],[7,0]]},'positions':{'least':0,'most':4}}",
        "{'linkwright-task':1,'target':'a','pivots':{'box':[[3,3],[6,6]]},'positions':{'least':0,'most':4}}"
    };
    for (size_t i = 0; i < sizeof good/sizeof *good; i++) {
        OWN(lw_task_file) b = { 0 };
        CHECK_OK(read(good[i], &b, &check_error));
    }
}

TEST(dwells_become_stations)
{
    static const char text[] = "{'linkwright-task':1,'stations':[{'angle':0,'theta':1},{'angle':3,'theta':2}],"
                               "'dwell':[{'from':1,'to':2,'theta':5,'points':3,'weight':4}]}";
    static const double angle[] = { 0, 1, 1.5, 2, 3 }, theta[] = { 1, 5, 5, 5, 2 }, weight[] = { 1, 4, 4, 4, 1 };
    OWN(lw_task_file) b = { 0 };
    lw_target t;
    CHECK_OK(read(text, &b, &check_error));
    CHECK_OK(lw_task_file_target(&b, &b.stations, &t, &check_error));
    CHECK_INT(t.n, 5);
    for (size_t i = 0; i < 5 && i < t.n; i++) {
        CHECK_NEAR(t.angle[i], angle[i], 1e-15, 0);
        CHECK_NEAR(t.theta[i], theta[i], 1e-15, 0);
        CHECK_NEAR(t.weight[i], weight[i], 1e-15, 0);
    }
    lw_target_free(&t);
    b.dwell[0].from = -1;                                /* the first station is inside now        */
    CHECK_FAILS(lw_task_file_target(&b, &b.stations, &t, &check_error), LW_E_ARG, "station 1");
}

TEST(tracers_have_targets_of_their_own)
{
    static const char text[] = "{'linkwright-task':1,'units':{'length':'mm','angle':'deg'},'tracers':["
                               "{'stations':[{'x':0,'y':0},{'x':3,'y':1}]},{'target':'b.csv','link':'output'},"
                               "{'stations':[{'theta':90,'angle':0},{'theta':45,'angle':1}]}],'forbidden':[{'circle':[[30,15],1]}]}";
    static const char columns[] = "{'linkwright-task':1,'units':{'length':'mm','angle':'deg'},'stations':["
                                  "{'x':0,'y':0,'x2':30,'y2':15,'theta2':90,'weight2':3},"
                                  "{'x':3,'y':1,'x2':5,'y2':5,'theta2':80,'weight2':2}],'point_links':['input'],'forbidden':[{'circle':[[30,15],1]}]}";
    OWN(lw_task_file) b = { 0 };
    lw_target t;
    CHECK_OK(read(text, &b, &check_error));
    CHECK_INT(b.n_also, 2);
    CHECK(b.stations.n == 2 && !b.target[0] && b.also[0].stations.n == 0 && b.also[1].stations.n == 2);
    CHECK_TEXT(b.also[0].target, "b.csv");
    CHECK_INT(b.spec.carrier[0], LW_CARRIER_OUTPUT);
    CHECK_INT(b.spec.carrier[1], LW_CARRIER_ANY);
    CHECK_NEAR(b.also[1].stations.theta[1], LW_PI/4, 0, 1e-15);
    lw_task_file_free(&b);
    CHECK_OK(read(columns, &b, &check_error));
    CHECK_INT(b.stations.n_also, 1);
    CHECK_INT(b.spec.carrier[0], LW_CARRIER_INPUT);
    CHECK_NEAR(b.stations.also[0].x[0], 0.03, 0, 1e-15);
    CHECK_NEAR(b.stations.also[0].theta[0], LW_PI/2, 0, 1e-15);
    CHECK_NEAR(b.stations.also[0].weight[1], 2, 0, 0);
    CHECK_FAILS(lw_task_file_target(&b, &b.stations, &t, &check_error), LW_E_ARG, "station 1 of point 2 lies inside a forbidden zone");
    b.spec.n_zone = 0;
    CHECK_OK(lw_task_file_target(&b, &b.stations, &t, &check_error));
    CHECK(t.n_also == 1 && t.also[0].y[1] == b.stations.also[0].y[1]);
    lw_target_free(&t);
    b.n_dwell = 1;
    CHECK_INT(lw_task_file_target(&b, &b.stations, &t, &check_error), LW_E_ARG);
}

TEST(a_station_in_a_forbidden_zone)
{
    static const char text[] = "{'linkwright-task':1,'stations':[{'x':0,'y':0},{'x':3,'y':1}],'forbidden':[{'circle':[[3,1.5],1]}]}";
    OWN(lw_task_file) b = { 0 };
    lw_target t;
    CHECK_OK(read(text, &b, &check_error));
    CHECK_FAILS(lw_task_file_target(&b, &b.stations, &t, &check_error), LW_E_ARG, "station 2 lies inside a forbidden zone");
}
