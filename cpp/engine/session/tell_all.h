// All-gather for rare events, through rank 0.
#pragma once

#include <utility>
#include <vector>

#include "base/fields.h"
#include "comm/message.h"
#include "engine/session/rank.h"

namespace motes::engine {

template <class T>
struct Told {
  std::vector<T> ranks;
};

template <class Visitor, class T>
constexpr void fields(Visitor& visit, Told<T>& told) {
  visit(told.ranks);
}

/// Returns every rank's `own`, by rank. Collective. T must have `fields`. All ranks send to rank 0, which answers all.
template <class T>
std::vector<T> tell_all(Rank& rank, const comm::Stamp& stamp, const T& own) {
  Session& session = rank.session;
  Told<T> told;
  comm::Message message;
  if (session.rank() > 0) {
    base::write_fields(own, message.bytes());
    session.comm().post(0, comm::Phase::recovery, stamp, std::move(message));
    const comm::Message answer = session.comm().expect(0, comm::Phase::recovery, stamp);
    base::Reader in = answer.reader();
    base::read_fields(in, told);
    return std::move(told.ranks);
  }
  told.ranks.push_back(own);
  for (int from = 1; from < session.size(); ++from) {
    const comm::Message said = session.comm().expect(from, comm::Phase::recovery, stamp);
    base::Reader in = said.reader();
    told.ranks.emplace_back();
    base::read_fields(in, told.ranks.back());
  }
  base::write_fields(told, message.bytes());
  const auto answer = session.comm().sealed(comm::Phase::recovery, stamp, std::move(message));
  for (int to = 1; to < session.size(); ++to) session.comm().post(to, answer);
  return std::move(told.ranks);
}

}  // namespace motes::engine
