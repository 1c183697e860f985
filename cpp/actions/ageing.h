// How ages grow without drift, although they are kept in single precision.
//
// An age is a number of steps times their length, rounded to float32. Adding a step to a rounded age would round again,
// and after hours the sum of these errors would be seconds. So the number of steps is found from the age, exactly as
// long as it has no more bits than the rounding leaves; one is added, and the product is rounded once.
//
// Ages that are no whole number of steps, such as those of jittered births, are counted with binary fractions: in 23
// bits, so that they too are rounded only when they double. Where sub-steps are too many for 23 bits, frames are
// counted, and the part of the frame that has passed is known.
#pragma once

namespace motes::actions {

/// What ages need to know of a (sub-)step.
struct Ageing {
  double per_second = 0;  // sub-steps per second
  double length = 0, rest = 0;  // seconds per sub-step: the first 29 bits, and what they leave out
  double frames_per_second = 0;
  double frame = 0;  // seconds per frame
  double start = 0, end = 0;  // the part of the frame that has passed before and after the sub-step
  float in_substeps = 0;  // ages below, in seconds, are counted in sub-steps
  float in_frames = 0;  // ages below are counted in frames; older ones grow by plain sums
};

/// Sub-step `substep` of a frame of `dt` seconds.
Ageing ageing_of(double dt, int substep, int substeps);

}  // namespace motes::actions
