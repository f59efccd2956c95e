// Choice of the compiled loops for the machine that the program runs on.
#pragma once

#include "pinchoff/types.hpp"

namespace pinchoff {

/// The widest instruction set of this build that this processor has. The environment variable
/// PINCHOFF_INSTRUCTION_SET may name a narrower one, for tests and comparisons.
const Kernels& best_kernels();

}  // namespace pinchoff
