// Ages that grow without drift although they are stored in single precision.
//
// An age is a number of steps times their length, rounded to float32. Adding a step to a rounded age would round again,
// and after hours these errors would add up to seconds. Instead, the number of steps is recovered from the age
// (exactly, as long as it has no more bits than the rounding leaves) and incremented, and the product is rounded once.
//
// Ages that are not a whole number of steps, such as those of jittered births, are counted with binary fractions in 23
// bits, so they too are rounded only when they double. If there are too many sub-steps for 23 bits, frames are counted
// instead, as the elapsed part of the frame is known.
#pragma once

namespace motes::actions {

/// The constants of a (sub-)step by which ages grow.
struct Ageing {
  double per_second = 0;  // sub-steps per second
  double length = 0, rest = 0;  // seconds per sub-step: the leading 29 bits, and the remainder
  double frames_per_second = 0;
  double frame = 0;  // seconds per frame
  double start = 0, end = 0;  // the elapsed part of the frame before and after the sub-step
  float in_substeps = 0;  // ages up to this, in seconds, are counted in sub-steps
  float in_frames = 0;  // ages up to this are counted in frames; older ones grow by plain addition
};

/// Returns the constants of sub-step `substep`, counted from 0, of a frame of `dt` seconds.
Ageing ageing_of(double dt, int substep, int substeps);

}  // namespace motes::actions
