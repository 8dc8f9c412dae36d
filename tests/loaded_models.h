/* tests/loaded_models.h - models with masses and loads, for the writers of other formats; with single quotes. */
#ifndef LW_TESTS_LOADED_MODELS_H
#define LW_TESTS_LOADED_MODELS_H

/* A slider-crank and a four-bar, each with all that the file can hold. */
static const char *const loaded[] = {
    "{'linkwright': 1, 'units': {'length': 'm'}, 'links': ['ground', {'name': 'crank', 'mass': 2, 'inertia': 0.02, 'centre': [0.1, 0]}, {'name': "
        "'rod', 'mass': 3, 'inertia': 0.05, 'centre': [0.45, 0.1]}, {'name': 'piston', 'mass': 1.5, 'inertia': 0.01, 'centre': [0.7, 0]}], 'joints': "
        "[{'name': 'O', 'links': ['ground', 'crank'], 'at': [0, 0]}, {'name': 'A', 'links': ['crank', 'rod'], 'at': [0.2, 0.1]}, {'name': 'B', "
        "'links': ['rod', 'piston'], 'at': [0.7, 0]}, {'name': 'S', 'kind': 't', 'links': ['ground', 'piston'], 'at': [0.7, 0], 'along': [1, 0]}], "
        "'input': {'joint': 'O'}, 'gravity': [1, -9.81], 'springs': [{'name': 'k', 'links': ['ground', 'rod'], 'at': [[0.4, 0.6], [0.45, 0.1]], "
        "'stiffness': 200, 'damping': 3, 'free': 0.3}, {'name': 't', 'joint': 'O', 'stiffness': 4, 'damping': 0.1, 'free': 0.2}], 'forces': "
        "[{'name': 'load', 'link': 'piston', 'at': [0.7, 0.05], 'fx': '-12'}, {'name': 'jet', 'link': 'rod', 'at': [0.3, 0.1], 'frame': 'link', "
        "'fy': '5', 'torque': '0.7'}], 'motors': [{'name': 'M', 'joint': 'O', 'stall': 3, 'free_speed': 20}], 'tracers': [{'name': 'P', 'link': "
        "'rod', 'at': [0.45, 0.3]}]}",
    "{'linkwright': 1, 'units': {'length': 'm'}, 'links': [{'name': 'a', 'mass': 1, 'inertia': 0.02, 'centre': [0, 0.1]}, 'ground', {'name': 'b', "
        "'mass': 2, 'inertia': 0.1, 'centre': [0.3, 0.4]}, {'name': 'c', 'mass': 1, 'inertia': 0.05, 'centre': [0.55, 0.2]}], 'joints': [{'name': "
        "'O', 'links': ['a', 'ground'], 'at': [0, 0]}, {'name': 'A', 'links': ['a', 'b'], 'at': [0, 0.2]}, {'name': 'B', 'links': ['b', 'c'], 'at': "
        "[0.6, 0.4]}, {'name': 'D', 'links': ['c', 'ground'], 'at': [0.5, 0]}], 'input': {'joint': 'O'}, 'gravity': [0, -9.81], 'springs': [{'name': "
        "'s', 'joint': 'D', 'stiffness': 20, 'free': 0.1, 'damping': 0.2}], 'motors': [{'name': 'M', 'joint': 'O', 'stall': -1, 'free_speed': -30}], "
        "'tracers': [{'name': 'P', 'link': 'b', 'at': [0.3, 0.6]}]}"
};

#define LOADED_COUNT (sizeof loaded/sizeof *loaded)

#endif
