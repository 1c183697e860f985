#include "comm/mpi/losses.h"

namespace motes::comm::MOTES_MPI_ABI::losses {

#ifdef MOTES_MPI_ULFM

bool can_be_survived() { return MPIX_Comm_iagree != nullptr; }  // the others came with it

bool survived() {
  if (!can_be_survived()) return false;
  int* on = nullptr;
  int found = 0;
  if (MPI_Comm_get_attr(MPI_COMM_WORLD, MPIX_FT, static_cast<void*>(&on), &found) != MPI_SUCCESS || found == 0)
    return false;
  return *on != 0;
}

bool is_loss(int code) {
  int kind = MPI_SUCCESS;
  MPI_Error_class(code, &kind);
  return kind == MPIX_ERR_PROC_FAILED || kind == MPIX_ERR_PROC_FAILED_PENDING || kind == MPIX_ERR_REVOKED;
}

int lost_rank(MPI_Comm comm) {
  MPI_Group all = MPI_GROUP_NULL;
  MPI_Group lost = MPI_GROUP_NULL;
  if (MPIX_Comm_get_failed(comm, &lost) != MPI_SUCCESS) return -1;
  int count = 0;
  int rank = -1;
  MPI_Group_size(lost, &count);
  if (count > 0) {
    const int first = 0;
    MPI_Comm_group(comm, &all);
    MPI_Group_translate_ranks(lost, 1, &first, all, &rank);
    MPI_Group_free(&all);
  }
  MPI_Group_free(&lost);
  return rank;
}

void revoke(MPI_Comm comm) { check(MPIX_Comm_revoke(comm), "revoking the communicator"); }

bool revoked(MPI_Comm comm) {
  int is = 0;
  check(MPIX_Comm_is_revoked(comm, &is), "checking whether the communicator is revoked");
  return is != 0;
}

void agree(MPI_Comm comm, int* flag, MPI_Request* request) {
  check(MPIX_Comm_iagree(comm, flag, request), "starting an agreement");
}

MPI_Comm shrunk(MPI_Comm comm) {
  while (true) {
    MPI_Comm left = MPI_COMM_NULL;
    const int code = MPIX_Comm_shrink(comm, &left);
    if (code != MPI_SUCCESS && !is_loss(code)) check(code, "creating a communicator of the remaining ranks");
    // If a rank dies meanwhile, some may succeed and others fail. An agreement that sees new losses also returns an
    // error, but its flag is valid.
    int all_have_one = code == MPI_SUCCESS ? 1 : 0;
    const int agreed = MPIX_Comm_agree(comm, &all_have_one);
    if (agreed != MPI_SUCCESS && !is_loss(agreed)) check(agreed, "agreeing on the remaining ranks");
    if (all_have_one != 0) return left;
  }
}

#else

bool can_be_survived() { return false; }
bool survived() { return false; }
bool is_loss(int) { return false; }
int lost_rank(MPI_Comm) { return -1; }
void revoke(MPI_Comm) {}
bool revoked(MPI_Comm) { return false; }
void agree(MPI_Comm, int*, MPI_Request*) {}
MPI_Comm shrunk(MPI_Comm) { return MPI_COMM_NULL; }

#endif

}  // namespace motes::comm::MOTES_MPI_ABI::losses
