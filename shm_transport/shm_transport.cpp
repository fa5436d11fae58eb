#include "shm_transport/shm_transport.h"

#include <algorithm>

#include "shm_transport/daemon/accepted_daemons.h"
#include "shm_transport/daemon/process_daemon.h"
#include "shm_transport/host/queue_places.h"
#include "shm_transport/host/statistics.h"
#include "shm_transport/ports/reader_port.h"
#include "shm_transport/ports/writer_port.h"
#include "shm_transport/wake/doorbells.h"

namespace sft::shm {

static_assert(ShmOptions::samples_max == iox::MAX_CHUNKS_HELD_PER_SUBSCRIBER_SIMULTANEOUSLY &&
              ShmOptions::samples_max == QueuePlaces::depth_max);

namespace {

using core::Availability;

/// The transport of one node, which uses the session of the process. When the daemon is lost and another one
/// comes, the transport first reports that the old session is lost, and later that a new one is ready.
class ShmTransport final : public core::SharedMemory {
 public:
  explicit ShmTransport(const ShmOptions& options) : options_(options), daemon_(ProcessDaemon::shared()) {}

  std::size_t max_sample_bytes() const noexcept override { return std::size_t{16} << 20; }  // sftd/pools.h

  std::uint32_t max_depth() const noexcept override { return options_.queue_limit; }

  Availability poll(Clock::time_point now) override {
    DaemonLink::State state = daemon_->advance(options_, now);
    if (session_ != nullptr && session_ != state.session) {
      session_.reset();
      return Availability::starting;
    }
    session_ = std::move(state.session);
    if (session_ != nullptr) session_->prepare_chunks();
    return state.availability;
  }

  std::string description() const override { return daemon_->description(); }
  bool lacks_daemon() const override { return daemon_->lacks_daemon(); }

  core::HostToken host_token() const override {
    return session_ != nullptr ? session_->token() : core::HostToken{};
  }

  bool may_write() const override { return session_ == nullptr || session_->can_write(); }

  Result<std::unique_ptr<core::LendingWriter>> open_writer(const core::WriterSpec& spec) override {
    if (session_ == nullptr) return not_ready();
    const auto deadline = Clock::now() + options_.port_deadline;
    const auto publisher = session_->create_publisher(spec.id, deadline);
    if (!publisher) return tl::unexpected(publisher.error());
    const auto keeper = session_->create_subscriber(spec.id, 0, deadline);
    if (!keeper) {
      (*publisher)->m_toBeDestroyed.store(true, std::memory_order_release);
      return tl::unexpected(keeper.error());
    }
    auto chunks = ChunkLender::make(session_, **publisher, **keeper, spec, options_.held_limit);
    return std::make_unique<ShmWriterPort>(std::move(chunks), pages_, statistics_, spec.max_blocking,
                                           session_->reader_accounts());
  }

  Result<std::unique_ptr<core::BorrowingReader>> open_reader(const core::ReaderSpec& spec) override {
    if (session_ == nullptr) return not_ready();
    session_->admit_writers(spec.doorbell.page);
    return std::make_unique<ShmReaderPort>(session_, spec, options_, statistics_);
  }

  Counters counters() const noexcept override {
    Counters counters;
    counters.malformed = statistics_->malformed.load(std::memory_order_relaxed);
    counters.over_limit = statistics_->over_limit.load(std::memory_order_relaxed);
    return counters;
  }

 private:
  tl::unexpected<Error> not_ready() const {
    return fail(Errc::unavailable, "shared memory: " + description());
  }

  const ShmOptions options_;
  const std::shared_ptr<ProcessDaemon> daemon_;
  const std::shared_ptr<DoorbellPages> pages_ = std::make_shared<DoorbellPages>(options_.wake_thread);
  const std::shared_ptr<Statistics> statistics_ = std::make_shared<Statistics>();
  std::shared_ptr<Session> session_;
};

}  // namespace

Result<std::unique_ptr<core::SharedMemory>> open_shm_transport(const ShmOptions& options) {
  const auto users = user_ids(options.daemon_users);
  if (!users) return tl::unexpected(users.error());
  ShmOptions clamped = options;
  clamped.daemon_users.clear();  // numbers follow: a name costs a look into a file, or at a server
  for (const uid_t user : *users) clamped.daemon_users.push_back(std::to_string(user));
  clamped.queue_limit = std::clamp(options.queue_limit, 1U, ShmOptions::samples_max);
  clamped.held_limit = std::clamp(options.held_limit, 1U, ShmOptions::samples_max);
  return std::make_unique<ShmTransport>(clamped);
}

}  // namespace sft::shm
