// A fixture for the intake of a subscriber with two queues, without ports, clocks or threads.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/seam/buffer_pool.h"
#include "core/subscribe/intake.h"
#include "tests/support/test_seed.h"

namespace sft::core {

using Decision = Intake::Decision;
using Inlet = Intake::Inlet;

struct Sent {
  std::uint64_t sequence = 0;
  EndpointId writer = 9;
  std::int64_t stamp_ns = 0;  ///< 0: the stamp equals the sequence
  std::uint64_t diverted = 0;
  std::int64_t diverted_ns = 0;
  std::uint32_t numbering = 0;
};

/// Two queues that the test fills take the place of the two ports. The test sets the time.
class IntakeTest : public sft::test::RandomTest {
 protected:
  void in_memory(const Sent& sent) { memory.push_back(sample(sent)); }
  void over_network(const Sent& sent) { network.push_back(sample(sent)); }

  /// Returns one decision about the samples that have arrived, without answering the question of the
  /// decision.
  Decision decide() {
    fill();
    LazyRealtime now(now_ns);
    return intake->next(now);
  }
  Decision answer_connected(bool yes) {
    LazyRealtime now(now_ns);
    return intake->connected(yes, now);
  }
  Decision answer_overtaken(SampleHandle found) {
    LazyRealtime now(now_ns);
    return intake->overtaken(std::move(found), now);
  }
  /// Answers questions until a sample can be taken, and returns that sample, or an empty one if none can be
  /// taken.
  Taken take() {
    Decision decision = decide();
    for (;; decision = follow_up(decision)) {
      if (decision == Decision::deliver) return intake->take();
      if (decision == Decision::nothing) return {};
    }
  }
  std::vector<std::uint64_t> taken() {
    std::vector<std::uint64_t> sequences;
    for (Taken next = take(); next.sample; next = take()) sequences.push_back(next.info.sequence);
    return sequences;
  }
  Taken latest() {
    Taken newest = take();
    for (Taken next = take(); next.sample; next = take()) intake->keep_newer(newest, std::move(next));
    intake->report_losses(newest);
    return newest;
  }

  void hear(EndpointId writer, std::chrono::nanoseconds lifespan = {}, std::uint32_t owed = 0) {
    Hearing hearing;
    hearing.source.writer = hearing.status.id = writer;
    hearing.offered.lifespan = lifespan;
    hearing.owed = owed;
    intake->accounts().hears({hearing}, now_ns);
  }
  SubscriberStatus status() const {
    SubscriberStatus counted;
    intake->accounts().describe(counted);
    return counted;
  }
  void reopen(const Intake::Options& options) { intake.emplace(options); }

  SampleHandle sample(const Sent& sent) {
    SampleHandle made = pool->take(256);
    made->writer = sent.writer;
    made->sequence = sent.sequence;
    made->source_stamp_ns = sent.stamp_ns == 0 ? static_cast<std::int64_t>(sent.sequence) : sent.stamp_ns;
    made->diverted_sequence = sent.diverted;
    made->diverted_stamp_ns = sent.diverted_ns;
    made->numbering = sent.numbering;
    return made;
  }

  static constexpr std::int64_t timeout_ns = 1000;
  static constexpr Intake::Options usual{.timeout = std::chrono::nanoseconds(timeout_ns)};
  const std::shared_ptr<BufferPool> pool = BufferPool::make(64 << 20);
  std::deque<SampleHandle> memory, network;
  bool is_connected = true;  ///< true: the subscriber is connected by UDP to all writers
  std::int64_t now_ns = 0;
  std::optional<Intake> intake{std::in_place, usual};

 private:
  void fill() {
    const auto fill_one = [&](Inlet inlet, std::deque<SampleHandle>& queue) {
      if (!intake->is_empty(inlet) || queue.empty()) return;
      intake->put(inlet, std::move(queue.front()));
      queue.pop_front();
    };
    fill_one(Inlet::memory, memory);
    fill_one(Inlet::network, network);
  }
  Decision follow_up(Decision decision) {
    if (decision == Decision::ask_connected) return answer_connected(is_connected);
    if (decision == Decision::ask_overtaken) return answer_overtaken(first_in_memory(intake->asked_about()));
    return decide();
  }
  SampleHandle first_in_memory(EndpointId writer) {
    const auto found = std::ranges::find_if(memory, [&](const auto& s) { return s->writer == writer; });
    if (found == memory.end()) return {};
    SampleHandle first = std::move(*found);
    memory.erase(found);
    return first;
  }
};

}  // namespace sft::core
