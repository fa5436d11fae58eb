#include "shm_transport/shm_transport.h"

#include <algorithm>
#include <map>

#include "shm_transport/daemon/accepted_daemons.h"
#include "shm_transport/daemon/process_daemon.h"
#include "shm_transport/host/queue_places.h"
#include "shm_transport/host/statistics.h"
#include "shm_transport/ports/reader_port.h"
#include "shm_transport/ports/writer_port.h"
#include "shm_transport/wake/doorbell_pages.h"

namespace sft::shm {

static_assert(ShmOptions::samples_max == iox::MAX_CHUNKS_HELD_PER_SUBSCRIBER_SIMULTANEOUSLY &&
              ShmOptions::samples_max == QueuePlaces::depth_max);

namespace {

using core::Availability;

/// The ports of writers that have no second port yet. The second port of a writer lists the chunks that the
/// writer holds.
class FirstPorts {
 public:
  using Port = iox::popo::PublisherPortData*;

  static void give_back(Port port) { port->m_toBeDestroyed.store(true, std::memory_order_release); }

  Port take(core::EndpointId writer) {
    const auto kept = ports_.extract(writer);
    return kept ? kept.mapped().port : nullptr;
  }
  void keep(core::EndpointId writer, Port port) { ports_[writer] = {port, Clock::now()}; }
  /// Gives back the ports of writers that the node no longer tries to open.
  void give_back_untaken(Clock::time_point now) {
    std::erase_if(ports_, [now](const auto& item) {
      if (now - item.second.since < kept_for) return false;
      give_back(item.second.port);
      return true;
    });
  }

 private:
  static constexpr std::chrono::seconds kept_for{2};
  struct Kept {
    Port port = nullptr;
    Clock::time_point since{};
  };
  std::map<core::EndpointId, Kept> ports_;
};

/// The transport of one node, which uses the session of the process. When the daemon is lost and another
/// daemon starts, the transport first reports that the old session is lost, and later that a new session is
/// ready.
class ShmTransport final : public core::SharedMemory {
 public:
  explicit ShmTransport(const ShmOptions& options) : options_(options), daemon_(ProcessDaemon::shared()) {}

  // The size of the largest chunk (sftd/pools.h).
  std::size_t max_sample_bytes() const noexcept override { return std::size_t{64} << 20; }

  std::uint32_t max_depth() const noexcept override { return options_.queue_limit; }

  Availability poll(Clock::time_point now) override {
    DaemonLink::State state = daemon_->advance(options_, now);
    if (session_ != nullptr && session_ != state.session) {
      first_ports_ = {};  // the ports are gone with the daemon's memory
      session_.reset();
      return Availability::starting;
    }
    session_ = std::move(state.session);
    first_ports_.give_back_untaken(now);
    if (session_ != nullptr) session_->prepare_chunks();
    return state.availability;
  }

  std::string description() const override { return daemon_->description(); }
  bool lacks_daemon() const override { return daemon_->lacks_daemon(); }

  core::HostToken host_token() const override {
    return session_ != nullptr ? session_->token() : core::HostToken{};
  }

  bool awaits_answer() const override { return session_ != nullptr && session_->awaits_answer(); }

  bool may_write() const override { return session_ == nullptr || session_->can_write(); }

  Result<std::shared_ptr<core::LendingWriter>> open_writer(const core::WriterSpec& spec) override {
    if (session_ == nullptr) return not_ready();
    const RoudiChannel::Timeouts timeouts{options_.port_wait, options_.port_deadline};
    // The first port is kept while the daemon has not answered for the second one.
    iox::popo::PublisherPortData* publisher = first_ports_.take(spec.id);
    if (publisher == nullptr) {
      const auto made = session_->create_publisher(spec.id, timeouts);
      if (!made) return tl::unexpected(made.error());
      publisher = *made;
    }
    const auto keeper = session_->create_subscriber(spec.id, 0, timeouts);
    if (!keeper) {
      if (session_->awaits_answer())
        first_ports_.keep(spec.id, publisher);
      else
        FirstPorts::give_back(publisher);
      return tl::unexpected(keeper.error());
    }
    return ShmWriterPort::make(session_, *publisher, **keeper, spec, options_.held_limit, pages_,
                               statistics_);
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
  FirstPorts first_ports_;  ///< ports that belong to `session_`
};

}  // namespace

Result<std::unique_ptr<core::SharedMemory>> open_shm_transport(const ShmOptions& options) {
  const auto users = user_ids(options.daemon_users);
  if (!users) return tl::unexpected(users.error());
  ShmOptions clamped = options;
  // Names of accounts are replaced by numbers, since a name must be looked up in a file or at a server.
  clamped.daemon_users.clear();
  for (const uid_t user : *users) clamped.daemon_users.push_back(std::to_string(user));
  clamped.queue_limit = std::clamp(options.queue_limit, 1U, ShmOptions::samples_max);
  clamped.held_limit = std::clamp(options.held_limit, 1U, ShmOptions::samples_max);
  return std::make_unique<ShmTransport>(clamped);
}

}  // namespace sft::shm
