#include "engine/log/log.h"

#include <filesystem>

namespace motes::engine {
namespace {

// Converts seconds to float: seven digits exceed the precision of clocks.
float seconds(double value) { return static_cast<float>(value); }

jsonl::JsonlRow row_of(const FrameRow& frame) {
  jsonl::JsonlRow row;
  row.field("frame", frame.frame).field("time", frame.time).field("particles", frame.particles);
  row.field("exchanged", frame.exchanged).field("exchanged_bytes", frame.exchanged_bytes);
  row.field("dropped", frame.dropped);
  row.field("imbalance", frame.imbalance).field("slowest_rank", frame.slowest_rank);
  row.field("t_frame_s", frame.times.frame).field("t_create_s", frame.times.create).field("t_act_s", frame.times.act);
  row.field("t_report_s", frame.times.report).field("t_exchange_s", frame.times.exchange);
  row.field("t_balance_s", frame.times.balance).field("t_render_s", frame.times.render);
  if (!frame.births_by.empty()) row.field("births_by", frame.births_by);
  if (!frame.render_path.empty()) {
    row.field("t_project_s", seconds(frame.times.project)).field("t_draw_s", seconds(frame.times.draw));
    row.field("t_assemble_s", seconds(frame.times.assemble));
    row.field("render_path", frame.render_path).field("records", frame.records);
    row.field("record_bytes", frame.record_bytes).field("render_bytes", frame.render_bytes);
  }
  if (!frame.image_sha256.empty()) row.field("image_sha256", frame.image_sha256);
  if (!frame.digests.empty()) row.field("particles_digest", particles::combine(frame.digests).text());
  return row;
}

// Writes the bounds of a domain: domain_lo and domain_hi for the first axis that is cut, the ids or the curve; bricks
// have further columns for the other axes.
void put_domain(const LoadRow& load, jsonl::JsonlRow& row) {
  static const char* const kNames[3][2] = {
      {"domain_x_lo", "domain_x_hi"}, {"domain_y_lo", "domain_y_hi"}, {"domain_z_lo", "domain_z_hi"}};
  const int first = load.axes.first() < 3 ? load.axes.first() : 0;
  const auto at = static_cast<std::size_t>(first);
  row.field("domain_lo", load.domain.low[at]).field("domain_hi", load.domain.high[at]);
  for (std::size_t axis = at + 1; axis < 3; ++axis) {
    if (!load.axes.has(static_cast<int>(axis))) continue;
    row.field(kNames[axis][0], load.domain.low[axis]).field(kNames[axis][1], load.domain.high[axis]);
  }
}

jsonl::JsonlRow row_of(const FrameRow& frame, const LoadRow& load, const std::string& host) {
  jsonl::JsonlRow row;
  row.field("frame", frame.frame).field("system", load.system).field("rank", load.rank).field("host", host);
  const Tally& tally = load.tally;
  row.field("n_start", tally.at_start).field("n_end", load.n_end);
  row.field("created", tally.created + load.children).field("killed", tally.killed);
  row.field("sent", tally.sent).field("received", tally.received).field("bytes_sent", tally.bytes_sent);
  row.field("t_compute_s", seconds(tally.compute_s)).field("t_rescaled_s", seconds(load.rescaled_s));
  row.field("t_exchange_s", seconds(load.exchange_s))
      .field("t_wait_s", seconds(load.wait_s))
      .field("t_image_s", seconds(load.image_s))
      .field("t_project_s", seconds(load.project_s));
  put_domain(load, row);
  row.field("speed", static_cast<float>(load.speed));
  row.field("pack_each_s", load.pack_s).field("unpack_each_s", load.unpack_s);
  row.field("search_each_s", load.search_s).field("migrant_bytes", static_cast<float>(load.migrant_bytes));
  if (const InteractionStats& interaction = load.interaction; interaction.interactions > 0) {
    row.field("interactions", std::uint64_t{interaction.interactions})
        .field("pairs", interaction.pairs)
        .field("ghosts", interaction.ghosts);
    row.field("interaction_bytes", interaction.bytes)
        .field("most_in_a_cell", std::uint64_t{interaction.most_in_a_cell});
    row.field("overlap_99", interaction.overlap_99)
        .field("neighbour_ranks", std::uint64_t{interaction.neighbour_ranks});
    row.field("t_interact_s", interaction.interact_s).field("t_interact_wait_s", interaction.wait_s);
  }
  return row;
}

// Returns a row of quantiles: columns x_q00, x_q01, ... for the first axis that is cut, the ids or the curve; bricks
// have further columns, named y or z, for the other axes.
jsonl::JsonlRow density_of(const FrameRow& frame, const LoadRow& load) {
  jsonl::JsonlRow row;
  row.field("frame", frame.frame).field("system", load.system).field("rank", load.rank);
  row.field("n", load.density.particles);
  for (std::size_t k = 0; k < load.ways.size(); ++k) {
    const char name[] = {'w', 'a', 'y', '_', 'q', static_cast<char>('0' + k), '\0'};
    row.field(name, load.ways[k]);
  }
  const int first = load.axes.first() < 3 ? load.axes.first() : 0;
  const float* q = load.density.quantiles;
  for (int axis = first; axis < 3; ++axis) {
    if (axis > first && !load.axes.has(axis)) continue;
    char name[] = "x_q00";
    if (axis > first) name[0] = "xyz"[axis];
    for (int k = 0; k <= kQuantiles; ++k, ++q) {
      name[3] = static_cast<char>('0' + k / 10);
      name[4] = static_cast<char>('0' + k % 10);
      if (load.density.particles == 0) {
        row.null(name);
      } else {
        row.field(name, *q);
      }
    }
  }
  return row;
}

jsonl::JsonlRow row_of(const FrameRow& frame, const RankTimes& of) {
  static const char* const kNames[comm::kActivities] = {"script_s",  "births_s", "act_s",  "talk_s",
                                                        "picture_s", "log_s",    "other_s"};
  jsonl::JsonlRow row;
  row.field("frame", frame.frame).field("rank", of.rank).field("wall_s", of.spent.wall_s);
  for (std::size_t i = 0; i < of.spent.activities.size(); ++i) row.field(kNames[i], seconds(of.spent.activities[i]));
  double waited = 0;
  for (const comm::Waited& wait : of.spent.waits) waited += wait.seconds;
  row.field("wait_s", seconds(waited))
      .field("messages_s", seconds(of.spent.messages_s))
      .field("chain_s", of.spent.chain_s);
  return row;
}

jsonl::JsonlRow row_of(const FrameRow& frame, int rank, const comm::Waited& wait) {
  jsonl::JsonlRow row;
  row.field("frame", frame.frame).field("rank", rank).field("waited_for", wait.rank);
  row.field("phase", std::string(comm::name(static_cast<comm::Phase>(wait.phase))))
      .field("seconds", seconds(wait.seconds));
  return row;
}

jsonl::JsonlRow row_of(const BalanceRow& balance) {
  jsonl::JsonlRow row;
  row.field("frame", balance.frame).field("system", balance.system);
  row.field("left_rank", balance.left_rank).field("right_rank", balance.right_rank);
  row.field("n_left", balance.left.particles).field("n_right", balance.right.particles);
  row.field("t_left_s", balance.left.seconds).field("t_right_s", balance.right.seconds);
  row.field("speed_left", balance.left.speed).field("speed_right", balance.right.speed);
  for (const auto& [name, value] : {std::pair{"ordered", balance.ordered}, std::pair{"given", balance.given}}) {
    if (value) {
      row.field(name, *value);
    } else {
      row.null(name);
    }
  }
  row.field("axis", domains::name_of(balance.axis));
  row.field("cut_before", balance.cut_before).field("cut_after", balance.cut_after);
  row.field("policy", balance.policy);
  return row;
}

}  // namespace

Log::Log(const std::string& directory, std::vector<std::string> hosts, std::uint64_t first_frame)
    : directory_(directory), hosts_(std::move(hosts)), first_frame_(first_frame) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) throw jsonl::LogError("log: cannot create " + directory + ": " + error.message());
  frames_ = jsonl::JsonlTable(directory + "/frames.jsonl", 1024, first_frame);
  load_ = jsonl::JsonlTable(directory + "/load.jsonl", 512, first_frame);
  density_ = jsonl::JsonlTable(directory + "/density.jsonl", 512, first_frame);
  times_ = jsonl::JsonlTable(directory + "/times.jsonl", 512, first_frame);
  waits_ = jsonl::JsonlTable(directory + "/waits.jsonl", 128, first_frame);
  links_ = jsonl::JsonlTable(directory + "/links.jsonl", 256, first_frame);
  balance_ = jsonl::JsonlTable(directory + "/balance.jsonl", 512, first_frame);
  events_ = jsonl::JsonlTable(directory + "/events.jsonl", 256, first_frame);
}

void Log::add(const FrameRow& row) {
  for (const LoadRow& load : row.load) {
    const auto rank = static_cast<std::size_t>(load.rank);
    load_.add(row_of(row, load, rank < hosts_.size() ? hosts_[rank] : ""));
    density_.add(density_of(row, load));
  }
  load_.write();
  density_.write();
  for (const RankTimes& times : row.ranks) {
    times_.add(row_of(row, times));
    for (const comm::Waited& wait : times.spent.waits) waits_.add(row_of(row, times.rank, wait));
  }
  times_.write();
  waits_.write();
  frames_.add(row_of(row));
  frames_.write();
}

void Log::add(const std::vector<Link>& links) {
  for (const Link& link : links) {
    jsonl::JsonlRow row;
    row.field("frame", first_frame_).field("rank", link.rank).field("other", link.other);
    links_.add(row.field("message_s", seconds(link.message_s)).field("byte_s", seconds(link.byte_s)));
  }
  links_.write();
}

void Log::add(const BalanceRow& row) { balance_.add(row_of(row)); }

void Log::write_balance() { balance_.write(); }

void Log::event(const std::string& kind, std::uint64_t frame, const std::string& text) {
  events_.add(jsonl::JsonlRow().field("frame", frame).field("kind", kind).field("text", text));
  events_.write();
}

void Log::sync() {
  for (jsonl::JsonlTable* table : {&load_, &density_, &times_, &waits_, &links_, &frames_, &balance_, &events_})
    table->sync();
  jsonl::sync_directory_of(directory_ + "/");
}

}  // namespace motes::engine
