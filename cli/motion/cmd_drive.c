/* linkwright drive - what the drives of a model have to do; how a servo axis follows its motion. */
#include "cli/motion/drive.h"

#define PLACE(member) offsetof(cli_drive_settings, member)

static const cli_option options[] = {
    { "from", 0, CLI_REAL, PLACE(from), "T", "0", "start of the cycle [s]", 0, 0, NULL, NULL },
    { "to", 0, CLI_REAL, PLACE(to), "T", "1",
      "end of the cycle [s]; simulate: of the run, without it half as long again as the motion", 0, 0, NULL, NULL },
    { "steps", 'n', CLI_INT, PLACE(steps), "N", "1000", 
      "number of time intervals of the cycle; simulate: print N + 1 rows instead of the figures", 1, 10000000, NULL, NULL },
    { "speed", 's', CLI_TEXT, PLACE(speed), "W", NULL,
      "drive the inputs without a motion at this constant speed [rad/s] or [m/s], or with a unit: \"60 rpm\"", 0, 0, NULL,
      NULL },
    { "plot", 'p', CLI_OUTPUT, PLACE(plot), "FILE", NULL,
      "load: draw torque over speed of each drive; simulate: draw the run over time; as SVG, PDF or PNG", 0, 0, NULL,
      NULL },
    { "band", 0, CLI_REAL, PLACE(band), "X", "0.001",
      "simulate: the axis has settled where its error stays below X [m] or [rad]", 1e-15, 1e9, NULL, NULL },
    { "matrices", 0, CLI_OUTPUT, PLACE(matrices), "FILE", NULL,
      "simulate: write the state matrices A, B, C, D of the axis and of the closed loop as JSON", 0, 0, NULL, NULL },
    { .name = NULL }
};

static const cli_action actions[] = {
    { "load", "MODEL.json",
      "Moves the model as its inputs prescribe and prints for each drive what the cycle asks of it: greatest and\n"
      "root-mean-square torque (of a slider force), greatest speed, greatest power, mean power, and the energy that the\n"
      "load gives to the drive and takes from it. Every degree of freedom of the model must be driven.\n",
      1, 1, cli_drive_load, CLI_LINKAGE | CLI_RESULTS },
    { "simulate", "SERVO.json",
      "Simulates the loop of a servo axis (docs/drive.md, \"Loop\"): motor, amplifier, elastic transmission with play,\n"
      "friction, encoder and sampled controllers. Prints the error, settling, overshoot, currents, voltages, heat and the\n"
      "energy balance; crossover and margins of each loop; the poles of the whole. -n prints rows over time.\n",
      1, 1, cli_drive_simulate, 0 },
    { .name = NULL }
};

const cli_command cli_drive_command = {
    .name = "drive",
    .words = "ACTION FILE",
    .title = "torque, speed and energy that the drives of a model need; servo loops",
    .examples =
        "  linkwright drive load examples/drives/lifting-arm.json --to 2.5          # torque, speed, power of each drive\n"
        "  linkwright drive load model.json --speed \"60 rpm\" --plot load.svg  # torque over speed\n"
        "  linkwright drive simulate examples/drives/servo-axis.json --plot loop.svg  # error, current, margins, poles\n",
    .about = "The cycle of a load is the time from --from to --to; it is taken to repeat.\n",
    .options = options,
    .settings_size = sizeof(cli_drive_settings),
    .actions = actions
};
