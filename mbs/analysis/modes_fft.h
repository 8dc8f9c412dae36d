/* mbs/analysis/modes_fft.h - eigenfrequencies from a free vibration: a check of mbs/equilibrium/modes.h. */
#ifndef LW_MBS_ANALYSIS_MODES_FFT_H
#define LW_MBS_ANALYSIS_MODES_FFT_H

#include "mbs/dynamics/dynamics.h"
#include "mbs/equilibrium/modes.h"

/* Eigenfrequencies found another way: from the peaks in the spectra of a small free vibration about q in which every
 * mode takes part.  The full equations of d are integrated, without friction; the matrices above are not used.  d: of a static
 * analysis, without consistent masses of elements, and not used for anything else afterwards.  peak (n_mode) [Hz]; NAN: the mode
 * does not vibrate, dies out too fast (damping above 0.1) or has no peak of its own near.  Loads are those at the start of d; its
 * driven inputs are held where they are in q.  LW_NOTHING: no mode vibrates; LW_E_NUMERIC: the run breaks off. */
lw_status lw_modes_from_spectra(lw_dynamics *d, const double *q, const lw_modes *modes, double *peak, lw_error *e);

#endif
