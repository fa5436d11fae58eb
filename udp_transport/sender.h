// The sending thread: takes what publishers queued and sends it, paced by
// destination, no destination waiting for another.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "udp_transport/datagram_io.h"
#include "udp_transport/outbox.h"

namespace sft::udp {

class Sender {
 public:
  explicit Sender(std::unique_ptr<DatagramSender> io);
  ~Sender();
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  Result<void> start(const std::string& thread_name);
  /// What is queued is not sent any more. Not from the sending thread.
  void stop();
  bool stopped() const { return stopped_.load(std::memory_order_acquire); }

  /// An outbox that was idle has something to send. Any thread.
  void schedule(std::shared_ptr<Outbox> outbox);

  /// For what a publisher's thread sends itself.
  SendOutcome try_send(const OutgoingBatch& batch) noexcept { return io_->try_send(batch); }

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct Flow {  ///< one job on its way to one destination
    Destination* destination;
    Fragmenter fragments;
  };
  struct Transfer {  ///< the present job of one outbox
    std::shared_ptr<Outbox> outbox;
    std::vector<Flow> flows;
  };

  void run();
  bool await_work();
  void begin(Transfer& transfer);
  bool advance(Transfer& transfer);
  bool advance(Flow& flow, WriterTally& tally);
  SendOutcome send(Destination& destination, std::size_t batches);

  static constexpr std::size_t batches_per_call = 8;

  std::unique_ptr<DatagramSender> io_;
  std::thread thread_;
  std::atomic<bool> stopped_{false};

  std::mutex mutex_;
  std::condition_variable work_;
  std::vector<std::shared_ptr<Outbox>> scheduled_;  ///< not yet seen by the thread

  // Of the sending thread alone.
  std::vector<std::shared_ptr<Outbox>> taken_;
  std::vector<Transfer> transfers_;
  std::vector<Transfer> spare_;  ///< kept for the memory that they hold
  Time wake_at_{};               ///< when the next flow may go on
  std::array<Batch, batches_per_call> batches_;
};

}  // namespace sft::udp
