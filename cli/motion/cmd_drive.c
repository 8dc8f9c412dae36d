/* linkwright drive - what the drives of a model have to do; how a servo axis follows its motion. */
#include "cli/motion/drive.h"

#define PLACE(member) offsetof(cli_drive_settings, member)

static const cli_option options[] = {
    { "from", 0, CLI_REAL, PLACE(from), "T", "0", "load, select: start of the cycle [s]", 0, 0, NULL, NULL },
    { "to", 0, CLI_REAL, PLACE(to), "T", "1",
      "load, select: end of the cycle [s]; simulate: of the run, without it half as long again as the motion", 0, 0, NULL, NULL },
    { "steps", 'n', CLI_INT, PLACE(steps), "N", "1000",
      "load, select: number of time intervals of the cycle; simulate: print N + 1 rows instead of the figures", 1, 10000000, NULL, NULL },
    { "speed", 's', CLI_TEXT, PLACE(speed), "W", NULL,
      "load, select: drive the inputs without a motion at this constant speed [rad/s] or [m/s], or with a unit: \"60 rpm\"", 0, 0, NULL, NULL },
    { "plot", 'p', CLI_PLOT, PLACE(plot), "FILE", NULL,
      "load: draw torque over speed of each drive; select: with the limits of the first choice; simulate: the run over time; as "
      "SVG, PDF or PNG", 0, 0, NULL,
      NULL },
    { "band", 0, CLI_REAL, PLACE(band), "X", "0.001",
      "simulate: the axis has settled where its error stays below X [m] or [rad]", 1e-15, 1e9, NULL, NULL },
    { "matrices", 0, CLI_OUTPUT, PLACE(matrices), "FILE", NULL,
      "simulate: write the state matrices A, B, C, D of the axis and of the closed loop as JSON", 0, 0, NULL, NULL },
    { "matrices-folder", 0, CLI_TEXT, PLACE(folder), "FOLDER", NULL,
      "simulate: write the matrices as CSV files plant-A.csv ... whole-D.csv, with names and units of states, inputs and outputs", 0, 0, NULL, NULL },
    { "bode", 0, CLI_PLOT, PLACE(bode), "FILE", NULL,
      "simulate: draw gain and phase of each open loop over frequency with its margins, and the poles of the whole (.svg, .pdf, "
      ".png)", 0, 0, NULL, NULL },
    { "motors", 0, CLI_INPUT, PLACE(motors), "FILE", NULL,
      "select: table of motors (CSV), or a catalogue that holds motors, gears and amplifiers", 0, 0, NULL, NULL },
    { "gears", 0, CLI_INPUT, PLACE(gears), "FILE", NULL,
      "select: table of gears; a gear with a radius moves a slide; without a table the motor turns the joint itself", 0, 0, NULL, NULL },
    { "amplifiers", 0, CLI_INPUT, PLACE(amplifiers), "FILE", NULL,
      "select: table of amplifiers; without it voltage and current are not limited", 0, 0, NULL, NULL },
    { "drive", 0, CLI_TEXT, PLACE(drive), "NAME", NULL, "select: only this drive of the model", 0, 0, NULL, NULL },
    { "inertia-ratio", 0, CLI_REAL, PLACE(inertia_ratio), "X", "10",
      "select: greatest ratio of the load's inertia, seen by the motor, to that of motor and gear; 0: any", 0, 1e9, NULL, NULL },
    { "results", 0, CLI_INT, PLACE(results), "N", "10", "select: number of choices to print", 1, 2e9, NULL, NULL },
    { "mass", 0, CLI_REAL, PLACE(mass), "M", NULL, "radius: the mass that is moved [kg]", 1e-15, 1e15, NULL, NULL },
    { "way", 0, CLI_REAL, PLACE(way), "S", NULL, "radius: the way from rest to rest [m]", 1e-9, 1e9, NULL, NULL },
    { "wanted-acceleration", 0, CLI_REAL, PLACE(acceleration), "A", NULL, "radius: the acceleration that is wanted [m/s^2]", 1e-9, 1e9, NULL, NULL },
    { .name = NULL }
};

static const cli_action actions[] = {
    { "load", "MODEL.json",
      "Moves the model as its inputs prescribe and prints for each drive what the cycle asks of it: greatest and\n"
      "root-mean-square torque (of a slider force), greatest speed, greatest power, mean power, and the energy that the\n"
      "load gives to the drive and takes from it. Every degree of freedom of the model must be driven.\n",
      1, 1, cli_drive_load, CLI_LINKAGE | CLI_RESULTS, NULL },
    { "simulate", "SERVO.json",
      "Simulates the loop of a servo axis (docs/drive.md, \"Loop\"): motor, amplifier, elastic transmission with play,\n"
      "friction, encoder and sampled controllers. Prints the error, settling, overshoot, currents, voltages, heat and the\n"
      "energy balance; crossover and margins of each loop; the poles of the whole. -n prints rows over time.\n",
      1, 1, cli_drive_simulate, 0, NULL },
    { "select", "MODEL.json --motors FILE",
      "Tries every motor with every gear and amplifier on each drive of the model over the cycle: speed, peak and\n"
      "root-mean-square torque of motor and gear, voltage, current and i^2 t of the amplifier, inertia ratio. It prints the\n"
      "choices that can do the cycle, the cheapest first (by price, else by mass, else by rated power), and how many percent\n"
      "of each limit they use. * marks a choice if no choice that is as cheap stays farther below its limits. If no choice\n"
      "can do the cycle, it prints the nearest ones and ends with exit code 1. --plot draws the load and the limits of the first choice of each drive.\n",
      1, 1, cli_drive_select, CLI_LINKAGE | CLI_RESULTS, NULL },
    { "radius", "MOTORS.csv --mass M --way S",
      "Prints the radius of the wheel on which each motor moves a mass over a distance, by the formulas of Makkonen 1999,\n"
      "beside what the axis truly does with it: acceleration, time of the way, and whether the wanted acceleration can be had\n"
      "with any radius.\n",
      1, 1, cli_drive_radius, 0, NULL },
    { .name = NULL }
};

const cli_command cli_drive_command = {
    .name = "drive",
    .words = "ACTION FILE",
    .title = "load of the drives of a model, motors that can carry it; servo loops",
    .examples =
        "  linkwright drive load examples/drives/lifting-arm.json --to 2.5          # torque, speed, power of each drive\n"
        "  linkwright drive load model.json --speed \"60 rpm\" --plot load.svg  # torque over speed\n"
        "  linkwright drive select examples/drives/lifting-arm.json --to 2.5 --motors examples/drives/motors.csv "
        "--gears examples/drives/gears.csv --amplifiers examples/drives/amplifiers.csv\n"
        "  linkwright drive radius examples/drives/paper-d.csv --mass 200 --way 4 --wanted-acceleration 20\n"
        "  linkwright drive simulate examples/drives/servo-axis.json --plot loop.svg  # the run over time; without it the figures\n"
        "  linkwright drive simulate examples/drives/servo-axis.json --bode bode.svg --matrices-folder axis   # for control tools\n",
    .about = "The cycle of a load is the time from --from to --to; it is taken to repeat.\n",
    .options = options,
    .settings_size = sizeof(cli_drive_settings),
    .actions = actions
};
