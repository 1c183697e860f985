// All-gather for rare events, through rank 0.
#pragma once

#include <utility>
#include <vector>

#include "base/fields.h"
#include "comm/message.h"
#include "engine/session/rank.h"

namespace motes::engine {

template <class T>
struct OfAllRanks {
  std::vector<T> ranks;
};

template <class Visitor, class T>
constexpr void fields(Visitor& visit, OfAllRanks<T>& all) {
  visit(all.ranks);
}

/// Returns every rank's `own`, by rank. Collective. T must have `fields`. All ranks send to rank 0, which answers all.
template <class T>
std::vector<T> tell_all(Rank& rank, const comm::Stamp& stamp, const T& own) {
  Session& session = rank.session;
  OfAllRanks<T> all;
  comm::Message message;
  if (session.rank() > 0) {
    base::write_fields(own, message.bytes());
    session.comm().post(0, comm::Phase::recovery, stamp, std::move(message));
    const comm::Message answer = session.comm().expect(0, comm::Phase::recovery, stamp);
    base::Reader in = answer.reader();
    base::read_fields(in, all);
    return std::move(all.ranks);
  }
  all.ranks.push_back(own);
  for (int from = 1; from < session.size(); ++from) {
    const comm::Message from_rank = session.comm().expect(from, comm::Phase::recovery, stamp);
    base::Reader in = from_rank.reader();
    all.ranks.emplace_back();
    base::read_fields(in, all.ranks.back());
  }
  base::write_fields(all, message.bytes());
  const auto answer = session.comm().sealed(comm::Phase::recovery, stamp, std::move(message));
  for (int to = 1; to < session.size(); ++to) session.comm().post(to, answer);
  return std::move(all.ranks);
}

}  // namespace motes::engine
