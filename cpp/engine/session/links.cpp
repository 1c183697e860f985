#include "engine/session/links.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "comm/clock.h"

namespace motes::engine {
namespace {

using comm::Message;
using comm::Phase;

constexpr int kMost = 8;                              // links of the manager, and links between calculators
constexpr int kTimes = 3;                             // the shortest of these counts: noise only adds time
constexpr std::size_t kBytes = std::size_t{1} << 17;  // in a long message, so that its latency hardly matters

// Returns the pairs of ranks to measure, evenly spaced.
std::vector<Link> pairs(const Session& session) {
  const roles::Cast& cast = session.cast();
  std::vector<Link> links;
  const int others = session.size() - 1, to_manager = std::min(others, kMost);
  for (int k = 0; k < to_manager; ++k) {
    const int other = k * others / to_manager;
    links.push_back({cast.manager, other < cast.manager ? other : other + 1});
  }
  const int neighbours = static_cast<int>(session.calculators()) - 1, between = std::min(neighbours, kMost);
  for (int k = 0; k < between; ++k) {
    const int left = k * neighbours / between;
    const Link link{session.rank_of(left), session.rank_of(left + 1)};
    if (link.rank != cast.manager && link.other != cast.manager) links.push_back(link);
  }
  return links;
}

void post(Session& session, int to, Message message) {
  session.comm().post(to, Phase::notes, session.stamp(), std::move(message));
}

Message expect(Session& session, int from) { return session.comm().expect(from, Phase::notes, session.stamp()); }

// Returns half the time until the other rank has sent a message of this size back.
double one_way_s(Session& session, int other, std::size_t bytes) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kTimes; ++i) {
    Message message;
    std::fill_n(message.bytes().extend(bytes), bytes, std::byte{});
    session.comm().await(other, Phase::notes);
    const double start = comm::wall_seconds();
    post(session, other, std::move(message));
    expect(session, other);
    least = std::min(least, (comm::wall_seconds() - start) / 2);
  }
  return least;
}

// Measures a link from its first rank; the second one sends every message back.
void measure(Session& session, Link& link) {
  if (session.rank() == link.rank) {
    link.message_s = one_way_s(session, link.other, 0);
    const double longer_s = one_way_s(session, link.other, kBytes) - link.message_s;
    link.byte_s = std::max(longer_s, 0.0) / static_cast<double>(kBytes);
  } else if (session.rank() == link.other) {
    for (int i = 0; i < 2 * kTimes; ++i) {
      const Message question = expect(session, link.rank);
      Message answer;
      answer.bytes().put_raw(question.payload().data(), question.payload().size());
      post(session, link.rank, std::move(answer));
    }
  }
}

}  // namespace

std::vector<Link> measure_links(Rank& rank) {
  Session& session = rank.session;
  const int manager = session.cast().manager;
  std::vector<Link> links = pairs(session);
  for (Link& link : links) {
    const bool managers = link.rank == manager;
    if (!managers && session.manages()) {  // the pair begins at the manager's word, so that no two use the network
      post(session, link.rank, Message());
      const Message costs = expect(session, link.rank);
      base::Reader in = costs.reader();
      link.message_s = in.get<double>();
      link.byte_s = in.get<double>();
      continue;
    }
    if (!managers && session.rank() == link.rank) expect(session, manager);
    measure(session, link);
    if (!managers && session.rank() == link.rank) {
      Message costs;
      costs.bytes().put(link.message_s);
      costs.bytes().put(link.byte_s);
      post(session, manager, std::move(costs));
    }
  }
  return session.manages() ? links : std::vector<Link>();
}

}  // namespace motes::engine
