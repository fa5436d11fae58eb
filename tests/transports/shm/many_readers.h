// A writer with many attached readers. The writer serves some of them in shared memory. The other readers
// stay attached, but are served over the network at that time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/seam/gate.h"
#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {

class ManyReaders : public ShmNodeTest {
 protected:
  static constexpr std::size_t readers = 64;
  static constexpr std::uint32_t depth = 8;
  using Sequences = std::vector<std::uint64_t>;

  /// The service that a reader gets from the writer.
  struct Service {
    bool is_served = true;
    std::shared_ptr<core::Gate> gate{};  ///< null if the reader has no conditions
  };
  using Services = std::vector<Service>;

  void SetUp() override {
    ShmNodeTest::SetUp();
    if (IsSkipped()) return;
    writer_.emplace(node(), 1);
    for (std::size_t i = 0; i < readers; ++i) {
      readers_.push_back(std::make_unique<Reader>(node(), depth, id_of(i)));
      ASSERT_TRUE(readers_.back()->port().connect({.writer = 1, .max_sample_bytes = 1 << 20}));
    }
    ASSERT_TRUE(eventually([this] {
      return std::ranges::all_of(readers_, [](auto& reader) { return reader->port().connected(1); });
    }));
  }
  void TearDown() override {
    readers_.clear();
    writer_.reset();
    ShmNodeTest::TearDown();
  }

  static core::EndpointId id_of(std::size_t reader) { return 1000 + reader; }
  static std::shared_ptr<core::Gate> gate(const std::string& conditions) {
    const Selection asked = frame_type().parse_selection("* @ " + conditions).value();
    return std::make_shared<core::Gate>(0, detail::Conditions(frame_type().type(), asked.gate().conditions),
                                        asked.gate_hash());
  }

  void serve(const Services& services) {
    std::vector<core::Route> routes;
    for (std::size_t i = 0; i < readers; ++i) {
      if (!services[i].is_served) continue;
      core::Route route{
          .reader = id_of(i), .destination = core::DoorbellAddress{}, .selection = frame_type().full()};
      route.gate = services[i].gate;
      routes.push_back(std::move(route));
    }
    writer_->port().set_routes(std::move(routes));
  }
  /// Serves all readers except those in `unserved`.
  void serve_all_but(const std::vector<std::size_t>& unserved) {
    Services services(readers);
    for (const std::size_t reader : unserved) services[reader].is_served = false;
    serve(services);
  }

  /// Returns the sequences of the samples that wait for the reader. Gives these samples back.
  Sequences take_all(std::size_t reader) {
    Sequences sequences;
    while (const core::SampleHandle sample = readers_[reader]->take())
      sequences.push_back(sequence_of(sample));
    return sequences;
  }
  /// Returns true if all samples were given back, so that the writer can lend the memory of the last one
  /// again.
  bool nobody_holds_a_sample() {
    if (writer_->send_frame() != core::SendStatus::sent) return false;
    const std::byte* sent = nullptr;
    for (std::size_t i = 0; i < readers; ++i)
      if (const core::SampleHandle sample = readers_[i]->take()) sent = sample->data;
    return sent != nullptr && writer_->loan(100)->data == sent;
  }

  std::optional<Writer> writer_;
  std::vector<std::unique_ptr<Reader>> readers_;
};

}  // namespace sft::test
