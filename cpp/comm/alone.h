// A world of one rank in a process that must leave MPI alone: one that a rank has forked off.
#pragma once

#include <memory>

#include "comm/transport.h"

namespace motes::comm {

/// Makes the transport of a rank that has no others. Needs no MPI, and never waits.
std::unique_ptr<Transport> make_alone();

}  // namespace motes::comm
