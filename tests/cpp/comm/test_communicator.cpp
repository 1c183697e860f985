// Headers, stamps, the mailbox and abandoned waits, on simulated ranks.
#include <cstring>
#include <exception>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "comm/clock.h"
#include "comm/communicator.h"
#include "comm/simulated_ranks.h"
#include "support/check.h"

namespace motes::test_communicator {
using namespace comm;

namespace {

Message number(std::uint64_t value) {
  Message message;
  message.bytes().put(value);
  return message;
}

std::uint64_t number_in(const Message& message) { return message.reader().get<std::uint64_t>(); }

// Runs sender and receiver under several orders of events; returns the error that ended the run.
template <class Sender, class Receiver>
std::string outcome(const Sender& sender, const Receiver& receiver) {
  std::string text = "none";
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    std::string now = "none";
    try {
      simulate({.seed = seed}, [&](SimulatedRank& self) {
        if (self.rank() == 0) {
          sender(self);
        } else {
          receiver(self);
        }
      });
    } catch (const std::exception& error) {
      now = error.what();
    }
    CHECK(seed == 0 || now == text);
    text = now;
  }
  return text;
}

Watch named() {
  Watch watch;
  watch.describe = [](int rank) {
    return "rank " + std::to_string(rank) + (rank == 0 ? " (manager)" : " (calculator 0)");
  };
  return watch;
}

void expect_one(SimulatedRank& self) {
  Communicator comm(self.transport(), named());
  comm.expect(0, Phase::report, {7, 3});
}

// Runs a sender whose transport carries messages that no communicator would send.
std::string forged(const std::function<void(Message&)>& forge) {
  return outcome(
      [&](SimulatedRank& self) {
        const auto transport = self.transport();
        while (!transport->entered()) transport->pause(0, 1);
        Message message = number(1);
        Header header;
        header.phase = Phase::report;
        header.frame = 7;
        header.turn = 3;
        message.set_header(header);
        forge(message);
        transport->send(1, Phase::report, std::make_shared<const Message>(std::move(message)));
      },
      expect_one);
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST(communicator_brings_messages_in_order_with_what_their_headers_say) {
  const std::string text = outcome(
      [](SimulatedRank& self) {
        Communicator comm(self.transport(), {});
        for (std::uint32_t turn = 0; turn < 20; ++turn) {
          comm.post(1, Phase::births, {3, turn}, number(turn), turn, turn % 2 == 1);
          comm.post(1, Phase::loads, {3, turn}, number(100 + turn));
        }
        CHECK(comm.bytes_sent() == 40 * (sizeof(Header) + 8));
        comm.finish();
      },
      [](SimulatedRank& self) {
        Communicator comm(self.transport(), {});
        for (std::uint32_t turn = 0; turn < 20; ++turn) {
          CHECK(number_in(comm.expect(0, Phase::loads, {3, turn})) == 100 + turn);
        }
        for (std::uint32_t turn = 0; turn < 20; ++turn) {
          const Message message = comm.expect(0, Phase::births, {3, turn});
          CHECK(number_in(message) == turn && message.header().count == turn);
          CHECK(message.header().failed == turn % 2);
        }
        CHECK(comm.bytes_sent() == 0 && comm.waited_s() > 0);
        comm.finish();
      });
  CHECK(text == "none");
}

TEST(communicator_refuses_a_message_of_another_place) {
  const auto sent = [](Stamp stamp) {
    return outcome(
        [&](SimulatedRank& self) {
          Communicator comm(self.transport(), {});
          comm.post(1, Phase::report, stamp, {});
        },
        expect_one);
  };
  CHECK(sent({7, 3}) == "none");
  CHECK(
      sent({8, 3}) ==
      "rank 0 (manager) sent a message of frame 8, turn 3, phase report where rank 1 (calculator 0) expected frame 7, "
      "phase report, turn 3");
  CHECK(has(sent({7, 2}), "frame 7, turn 2, phase report where"));
}

TEST(communicator_refuses_what_is_no_message_or_has_another_length) {
  CHECK(forged([](Message&) {}) == "none");
  const auto changed = [](auto change) {
    return [change](Message& message) {
      Header header = message.header();
      change(header);
      message.bytes().set(0, header);
    };
  };
  const std::string longer = forged(changed([](Header& header) { header.payload_bytes = 9; }));
  CHECK(longer == "rank 0 (manager) sent 8 bytes where its header says 9: frame 7, phase report");
  CHECK(has(forged(changed([](Header& header) { header.payload_bytes = 7; })), "sent 8 bytes where its header says 7"));
  CHECK(has(forged(changed([](Header& header) { header.magic = 1; })), "rank 0 (manager) sent a message"));
  CHECK(has(forged(changed([](Header& header) { header.phase = Phase::births; })), "phase births where"));
  CHECK(has(forged(changed([](Header& header) { header.phase = static_cast<Phase>(77); })), "phase unknown where"));
  CHECK(has(forged([](Message& message) { message.bytes().resize(12); }), "ends too early"));
}

TEST(communicator_keeps_messages_to_oneself) {
  simulate({.ranks = 1}, [](SimulatedRank& self) {
    Communicator comm(self.transport(), {});
    comm.post(0, Phase::begin, {0, 1}, number(5));
    comm.post(0, Phase::report, {0, 1}, number(6));
    comm.post(0, Phase::begin, {0, 2}, number(7));
    CHECK(comm.bytes_sent() == 0);
    CHECK(number_in(comm.expect(0, Phase::report, {0, 1})) == 6);
    CHECK(number_in(comm.expect(0, Phase::begin, {0, 1})) == 5);
    CHECK(number_in(comm.expect(0, Phase::begin, {0, 2})) == 7);
    CHECK_THROWS(comm.expect(0, Phase::begin, {0, 3}), CommError);  // instead of waiting forever
    comm.post(0, Phase::begin, {1, 4}, number(8));
    CHECK_THROWS(comm.expect(0, Phase::begin, {1, 5}), CommError);
    comm.finish();
  });
}

TEST(communicator_carries_large_messages_whole) {
  std::vector<std::uint32_t> numbers(3'000'000);
  std::iota(numbers.begin(), numbers.end(), 0u);
  const std::string text = outcome(
      [&](SimulatedRank& self) {
        Communicator comm(self.transport(), {});
        Message message;
        message.bytes().put_raw(numbers.data(), 4 * numbers.size());
        comm.post(1, Phase::gather, {}, std::move(message), numbers.size());
        comm.post(1, Phase::gather, {}, number(2));
        comm.finish();
      },
      [&](SimulatedRank& self) {
        Communicator comm(self.transport(), {});
        const Message message = comm.expect(0, Phase::gather, {});
        CHECK(message.payload().size() == 4 * numbers.size() && message.header().count == numbers.size());
        CHECK(std::memcmp(message.payload().data(), numbers.data(), 4 * numbers.size()) == 0);
        CHECK(number_in(comm.expect(0, Phase::gather, {})) == 2);
        comm.finish();
      });
  CHECK(text == "none");
}

TEST(a_wait_that_was_abandoned_can_be_taken_up_again) {
  struct Interrupt : std::exception {};
  const std::string text = outcome(
      [](SimulatedRank& self) {
        Communicator comm(self.transport(), {});
        spend(1);
        comm.post(1, Phase::records, {0, 1}, number(1));
        comm.post(1, Phase::records, {0, 2}, number(2));
        comm.finish();
      },
      [](SimulatedRank& self) {
        int looks = 0;
        Watch watch;
        watch.while_waiting = [&](int rank) {
          CHECK(rank == 0);
          if (++looks == 3) throw Interrupt();
        };
        Communicator comm(self.transport(), watch);
        CHECK_THROWS(comm.expect(0, Phase::records, {0, 1}), Interrupt);
        CHECK(looks == 3);
        CHECK(number_in(comm.expect(0, Phase::records, {0, 1})) == 1);
        CHECK(number_in(comm.expect(0, Phase::records, {0, 2})) == 2);
        CHECK(looks > 15);  // every 50 ms of the second that the other rank needs
        comm.finish();
      });
  CHECK(text == "none");
}

TEST(a_communicator_that_is_given_up_leaves_its_peers_alone) {
  const std::string text = outcome(
      [](SimulatedRank& self) {
        Communicator comm(self.transport(), {});
        comm.post(1, Phase::records, {0, 1}, number(1));
      },
      [](SimulatedRank& self) {
        Communicator comm(self.transport(), {});
        CHECK(number_in(comm.expect(0, Phase::records, {0, 1})) == 1);
      });
  CHECK(text == "none");
}

}  // namespace motes::test_communicator
