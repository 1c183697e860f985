// A world of one rank, for a process that a rank has forked and that must not call MPI.
#pragma once

#include <memory>

#include "comm/transport.h"

namespace motes::comm {

/// Makes the transport of a world of one rank. Needs no MPI and never waits.
std::unique_ptr<Transport> make_alone();

}  // namespace motes::comm
