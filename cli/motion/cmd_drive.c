/* linkwright drive - what the drives of a model have to do. */
#include "cli/motion/drive.h"

#define PLACE(member) offsetof(cli_drive_settings, member)

static const cli_option options[] = {
    { "from", 0, CLI_REAL, PLACE(from), "T", "0", "start of the cycle [s]", 0, 0, NULL, NULL },
    { "to", 0, CLI_REAL, PLACE(to), "T", "1", "end of the cycle [s]", 0, 0, NULL, NULL },
    { "steps", 'n', CLI_INT, PLACE(steps), "N", "1000", "number of time intervals of the cycle", 1, 10000000, NULL, NULL },
    { "speed", 's', CLI_TEXT, PLACE(speed), "W", NULL,
      "drive the inputs without a motion at this constant speed [rad/s] or [m/s], or with a unit: \"60 rpm\"", 0, 0, NULL,
      NULL },
    { "plot", 'p', CLI_OUTPUT, PLACE(plot), "FILE", NULL,
      "load: draw torque over speed of each drive, as SVG, PDF or PNG", 0, 0, NULL, NULL },
    { .name = NULL }
};

static const cli_action actions[] = {
    { "load", "MODEL.json",
      "Moves the model as its inputs prescribe and prints for each drive what the cycle asks of it: greatest and\n"
      "root-mean-square torque (of a slider force), greatest speed, greatest power, mean power, and the energy that the\n"
      "load gives to the drive and takes from it. Every degree of freedom of the model must be driven.\n",
      1, 1, cli_drive_load, CLI_LINKAGE | CLI_RESULTS },
    { .name = NULL }
};

const cli_command cli_drive_command = {
    .name = "drive",
    .words = "ACTION FILE",
    .title = "torque, speed, power and energy that the drives of a model need",
    .examples =
        "  linkwright drive load examples/drives/lifting-arm.json --to 2.5          # torque, speed, power of each drive\n"
        "  linkwright drive load model.json --speed \"60 rpm\" --plot load.svg  # torque over speed\n",
    .about = "The cycle is the time from --from to --to; it is taken to repeat.\n",
    .options = options,
    .settings_size = sizeof(cli_drive_settings),
    .actions = actions
};
