#include "frame/report.h"

#include <stdexcept>

namespace motes::frame {
namespace {

using particles::Bytes;
using particles::Reader;

template <class T>
void put_list(Bytes& out, const std::vector<T>& list) {
  out.put(static_cast<std::uint64_t>(list.size()));
  out.put_raw(list.data(), list.size() * sizeof(T));
}

// Into a list that may have room already.
template <class T>
void get_list(Reader& in, std::vector<T>& list) {
  const auto count = in.get<std::uint64_t>();
  if (count > in.left() / sizeof(T)) throw std::runtime_error("a report ends too early");
  list.resize(count);
  const auto bytes = in.take(count * sizeof(T));
  if (count != 0) std::memcpy(list.data(), bytes.data(), bytes.size());
}

void put(Bytes& out, const Failure& failure) {
  out.put(failure.kind);
  out.put_text(failure.action);
  out.put_text(failure.text);
}

Failure get_failure(Reader& in) {
  Failure failure;
  failure.kind = in.get<Failure::Kind>();
  failure.action = in.get_text();
  failure.text = in.get_text();
  return failure;
}

void put(Bytes& out, const SystemReport& system) {
  out.put(system.at_start);
  out.put(system.created);
  out.put(system.killed);
  out.put(system.kept);
  out.put(system.compute_s);
  put_list(out, system.sent);
  out.put(system.digest);
  out.put(system.oldest);
  out.put(static_cast<std::uint32_t>(system.events.size()));
  for (const std::vector<recording::Event>& events : system.events) put_list(out, events);
}

void get_system(Reader& in, SystemReport& system) {
  system.at_start = in.get<std::uint64_t>();
  system.created = in.get<std::uint64_t>();
  system.killed = in.get<std::uint64_t>();
  system.kept = in.get<std::uint64_t>();
  system.compute_s = in.get<double>();
  get_list(in, system.sent);
  system.digest = in.get<particles::Digest>();
  system.oldest = in.get<std::uint64_t>();
  const auto rules = in.get<std::uint32_t>();
  if (rules > in.left() / sizeof(std::uint64_t)) throw std::runtime_error("a report ends too early");
  system.events.resize(rules);
  for (std::vector<recording::Event>& events : system.events) get_list(in, events);
}

}  // namespace

void write(const Report& report, Bytes& out) {
  put(out, report.failure);
  out.put(static_cast<std::uint64_t>(report.record.size()));
  out.put_raw(report.record.data(), report.record.size());
  out.put(static_cast<std::uint32_t>(report.systems.size()));
  for (const SystemReport& system : report.systems) put(out, system);
  out.put(report.tail.valid);
  out.put(report.tail.frame);
  out.put(report.tail.times);
  put_list(out, report.tail.bytes_sent);
  put_list(out, report.tail.density);
  put_list(out, report.tail.children);
  out.put_text(report.tail.image_sha256);
}

void read(Reader& in, Report& report) {
  report.failure = get_failure(in);
  const auto record = in.take(in.get<std::uint64_t>());
  report.record.clear();
  report.record.put_raw(record.data(), record.size());
  const auto systems = in.get<std::uint32_t>();
  if (systems > in.left() / sizeof(SystemReport::at_start)) throw std::runtime_error("a report ends too early");
  report.systems.resize(systems);
  for (SystemReport& system : report.systems) get_system(in, system);
  report.tail.valid = in.get<bool>();
  report.tail.frame = in.get<std::uint64_t>();
  report.tail.times = in.get<PhaseTimes>();
  get_list(in, report.tail.bytes_sent);
  get_list(in, report.tail.density);
  get_list(in, report.tail.children);
  report.tail.image_sha256 = in.get_text();
}

void write(const Verdict& verdict, Bytes& out) {
  put(out, verdict.failure);
  out.put(verdict.failed_rank);
  put_list(out, verdict.ranks);
  put_list(out, verdict.alive);
  put_list(out, verdict.digests);
  put_list(out, verdict.spawned);
  put_list(out, verdict.oldest);
  out.put(verdict.asks);
}

Verdict read_verdict(Reader& in) {
  Verdict verdict;
  verdict.failure = get_failure(in);
  verdict.failed_rank = in.get<std::int32_t>();
  get_list(in, verdict.ranks);
  get_list(in, verdict.alive);
  get_list(in, verdict.digests);
  get_list(in, verdict.spawned);
  get_list(in, verdict.oldest);
  verdict.asks = in.get<bool>();
  return verdict;
}

void write(const Orders& orders, Bytes& out) {
  put_list(out, orders.sources);
  put_list(out, orders.requests);
  put_list(out, orders.partners);
  put_list(out, orders.parents);
}

Orders read_orders(Reader& in) {
  Orders orders;
  get_list(in, orders.sources);
  get_list(in, orders.requests);
  get_list(in, orders.partners);
  get_list(in, orders.parents);
  return orders;
}

void write(const Proposal& proposal, Bytes& out) {
  out.put(proposal.request);
  out.put(proposal.gift);
  put_list(out, proposal.histogram.edges);
  put_list(out, proposal.histogram.counts);
}

Proposal read_proposal(Reader& in) {
  Proposal proposal;
  proposal.request = in.get<Request>();
  proposal.gift = in.get<balance::Gift>();
  get_list(in, proposal.histogram.edges);
  get_list(in, proposal.histogram.counts);
  return proposal;
}

}  // namespace motes::frame
