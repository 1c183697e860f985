// An engine that survives the loss of ranks: it overrides the collective calls of Engine to repeat them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/engine.h"
#include "engine/recovery/loss.h"
#include "engine/recovery/replicas.h"
#include "engine/recovery/standing.h"

namespace motes::engine {

/// Until survive_losses(), it is an ordinary engine. From then on, a collective call that a loss interrupts is repeated
/// on the remaining ranks, in the world as it was; if that is impossible, it throws Unrecoverable on all of them.
class RecoveringEngine : public Engine {
 public:
  using Engine::Engine;

  /// Survives losses of ranks from now on: makes replicas of all particles before every `every`-th frame. Call after
  /// start(), on all ranks; no effect if the communicator cannot survive losses.
  void survive_losses(std::uint64_t every, Bystander bystander);
  /// Makes replicas of restored particles. Throws RankLost if a rank is lost before all ranks have theirs. Collective,
  /// after restore_rows() on all ranks.
  void copy_restored();
  /// Returns how often ranks were lost so far.
  std::uint32_t losses() const { return replicas_.losses; }

  void keep_preview(int system) override;
  void on_orders(std::function<std::string()> orders) override;

  // Collective. Arguments are kept until the next call: if ranks are lost meanwhile, ranks on which this call has ended
  // make it again, so functions are called again, and their result must not depend on how often.
  void finish() override;
  void secure(const std::function<void()>& first = {}) override;
  std::vector<std::string> tell(const std::function<std::string()>& say) override;
  void run_frame(const std::optional<image::View>& view, const std::string& argument = "") override;
  void redraw(const image::View& view, const std::string& argument = "") override;
  void hear_orders(const std::string& argument = "") override;
  std::vector<particles::Digest> digest() override;
  std::unique_ptr<particles::Store> gather(int system, bool to_all) override;
  program::Totals sum(int system, recording::Verb verb, const program::Sum& what) override;
  surfaces::Skin surface(int system, const surfaces::Measure& measure) override;
  Notes prepare_write(const std::string& what, bool reads, const std::function<Note()>& prepare) override;

 private:
  // The last collective call that ended on this rank; repeated if it did not end on others.
  struct Ended {
    std::uint64_t count = 0;  // number of calls so far, this one included
    bool frame = false;  // the call is a frame, whose list is kept
    std::function<void()> again;  // repeats a call that is not a frame; empty if it cannot be repeated
    std::vector<std::size_t> before, after;  // lengths of the lists before and after the call
    std::vector<Outside> outside;  // what the script had told each system before the call
  };

  // State of the call that a loss interrupted.
  struct Interrupted {
    std::vector<std::unique_ptr<System>> systems;
    std::function<void(const Call&)> callback;
    std::uint64_t unsaved_from = UINT64_MAX;
    Announced announced;
    std::string refusal;
  };

  template <class Now>
  auto surviving(const Now& now, bool frame, std::function<void()> again = {});
  template <class Call>
  auto repeatable(const Call& call);
  std::vector<std::size_t> lengths() const;
  std::vector<Outside> outside() const;
  void tell_systems(const std::vector<Outside>& outside);
  void recover();
  void regroup();
  void bring_lists_back();
  Standing standing() const;
  void start_again(const Generation& from);
  void go_back(const WayBack& way);
  void run_again(const WayBack& way, bool ahead);
  void replay_frame(const KeptList& list, const WayBack& way);
  void record_items(const std::vector<std::size_t>& from, const std::vector<std::size_t>& to);

  Replicas replicas_;
  Bystander bystander_;
  Ended last_;
  std::vector<std::size_t> before_;  // lengths of the lists when the current call began
  std::vector<Outside> outside_before_;  // what the script had told each system then
  std::uint64_t frame_before_ = 0;  // frame when the current call began
  bool wrote_ = false;  // the script wrote to particles in the current frame
  bool recovering_ = false;
  std::unique_ptr<Interrupted> interrupted_;
  std::optional<Announced> announced_;  // from ranks that completed the current call already
  Loss loss_;
};

}  // namespace motes::engine
