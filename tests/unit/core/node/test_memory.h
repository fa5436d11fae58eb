// Shared memory with ports and a daemon that the test controls.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/platform/clock.h"
#include "tests/unit/core/seam/idle_ports.h"

namespace sft::core {

/// Shared memory of a daemon. It counts its ports, and the test sets the results of their functions.
class TestMemory final : public IdleSharedMemory {
 public:
  class Writer final : public IdleLendingWriter {
   public:
    explicit Writer(TestMemory& memory) : memory_(memory) { ++memory_.writers; }
    ~Writer() override { --memory_.writers; }
    SendStatus send(const SampleHandle&) noexcept override { return SendStatus::sent; }
    void set_routes(std::vector<Route> given) override { memory_.routes = std::move(given); }
    std::string why_unreachable(const Route&) override { return memory_.why_unreachable; }

   private:
    TestMemory& memory_;
  };
  class Reader final : public IdleBorrowingReader {
   public:
    explicit Reader(TestMemory& memory) : memory_(memory) { ++memory_.readers; }
    ~Reader() override { --memory_.readers; }
    bool some_wait() const noexcept override { return memory_.samples_wait; }
    Result<void> connect(const Source& source) override {
      memory_.asked_for.push_back(source.writer);
      if (memory_.refusal) return fail(*memory_.refusal, "it does not do that");
      memory_.connections.insert(source.writer);
      return {};
    }
    bool connected(EndpointId) const noexcept override { return memory_.attaches; }
    HistoryProgress history(EndpointId) const noexcept override { return memory_.progress; }
    std::uint64_t arrivals(EndpointId) noexcept override { return memory_.arrivals; }
    std::uint64_t held_too_many() const noexcept override { return memory_.held_too_many; }
    void disconnect(EndpointId writer) noexcept override { memory_.connections.erase(writer); }

   private:
    TestMemory& memory_;
  };

  HostToken host_token() const override {
    HostToken token;
    token.bytes.fill(daemon);
    return token;
  }
  Result<std::shared_ptr<LendingWriter>> open_writer(const WriterSpec&) override {
    ++openings;
    if (is_full) return fail(Errc::unavailable, "no port is left");
    return std::make_unique<Writer>(*this);
  }
  Result<std::unique_ptr<BorrowingReader>> open_reader(const ReaderSpec&) override {
    return std::make_unique<Reader>(*this);
  }

  std::uint8_t daemon = 1;
  bool is_full = false;
  bool attaches = true;
  HistoryProgress progress = HistoryProgress::awaited;
  int writers = 0;
  int readers = 0;
  bool samples_wait = false;         ///< true: samples wait in the queue of each reader
  std::uint64_t arrivals = 0;        ///< the number of samples that each reader port reports for each writer
  std::uint64_t held_too_many = 0;   ///< the count that each reader port reports
  int openings = 0;                  ///< the number of attempts to open a writer port, including refused ones
  std::vector<Route> routes;         ///< the routes that were set last, on any writer port
  std::string why_unreachable;       ///< the reason that writer ports report for each reader
  std::set<EndpointId> connections;  ///< the writers that readers are connected to
  std::vector<EndpointId> asked_for;  ///< the writers to which connections were requested, in order
  std::optional<Errc> refusal;        ///< the error of each attempt to connect; empty: attempts succeed
};

}  // namespace sft::core
