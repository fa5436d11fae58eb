#include "shm_transport/sftd/roudi_host.h"

#include <algorithm>
#include <charconv>
#include <tuple>

#include "core/platform/clock.h"
#include "shm_transport/host/host_file.h"
#include "shm_transport/host/socket_address.h"
#include "shm_transport/sftd/past_services.h"
#include "shm_transport/sftd/stale_files.h"

namespace sft::shm {

using iox::runtime::IpcMessage;
using iox::runtime::IpcMessageErrorType;
using iox::runtime::IpcMessageType;

namespace {

constexpr std::chrono::milliseconds healing_interval{20};
constexpr std::chrono::seconds audit_interval{1};
constexpr int goodbye_looks_max = 10;

iox::roudi::RouDi::RoudiStartupParameters startup_parameters() {
  constexpr bool kill_processes_at_exit = false;
  return {iox::roudi::MonitoringMode::OFF, kill_processes_at_exit,
          iox::roudi::RouDi::RuntimeMessagesThreadStart::DEFER_START};
}

pid_t pid_in(const IpcMessage& registration) {
  const std::string text = registration.getElementAtIndex(2);
  pid_t pid = 0;
  std::from_chars(text.data(), text.data() + text.size(), pid);
  return pid;
}

void send_to(const std::string& client, const std::string& text) {
  const Descriptor channel(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const sockaddr_un address = socket_address("/tmp/" + client);
  std::ignore = sendto(channel.get(), text.c_str(), text.size() + 1, MSG_NOSIGNAL,
                       reinterpret_cast<const sockaddr*>(&address), sizeof address);
}

}  // namespace

RoudiHost::RoudiHost(HostMemory& memory, iox::roudi::PortManager& ports, const Groups& groups,
                     const Limits& limits, const Log& log)
    : RouDi(memory, ports, startup_parameters()),
      groups_(groups),
      limits_(limits),
      log_(log),
      ports_(ports),
      port_pool_(*memory.portPool().value()),
      lock_recovery_(port_pool_, clients_, log),
      auditor_(port_pool_, *memory.samples().pools),
      monitor_(port_pool_, *memory.samples().pools, memory.management()) {
  note_usage();  // so that usage() has a result from the beginning
  hooks_may_run_ = true;
  healing_ = std::thread([this] { heal_until_stopped(); });
  startProcessRuntimeMessagesThread();
}

RoudiHost::~RoudiHost() {
  shutdown();
  {
    const core::Lock lock(mutex_);
    stopping_ = true;
  }
  stop_.notify_one();
  healing_.join();
}

void RoudiHost::processMessage(const IpcMessage& message, const IpcMessageType& type,
                               const iox::RuntimeName_t& name) noexcept {
  // Every process that may write to the socket can send a message. The name in the message becomes the path
  // of a socket. iceoryx writes to that path, and the daemon removes it when no process listens there any
  // more. So the name must be checked.
  if (!is_runtime_name(name.c_str()))
    return log_.debug("ignored a message with a name that no program of SFT has");
  if (refuse_over_limit(type, name)) return;
  if (type == IpcMessageType::REG) return register_client(message, name);
  if (type == IpcMessageType::TERMINATION) {
    // The ports of this process are about to be destroyed. iceoryx aborts if the lock of such a port is
    // closed.
    clients_.remove(name.c_str());
    for (int i = 0; i < goodbye_looks_max && !lock_recovery_.recover(); ++i)
      std::this_thread::sleep_for(healing_interval);
    log_.debug(std::string(name.c_str()) + " says goodbye");
  }
  RouDi::processMessage(message, type, name);
  note_ports();
}

/// Registers the process as a member of the group of writers. The kernel decides which segments a process
/// can map. iceoryx would look up the groups of the user in files, which do not have all groups.
void RoudiHost::register_client(const IpcMessage& registration, const iox::RuntimeName_t& name) {
  if (registration.getNumberOfElements() != 6) return log_.debug("ignored a malformed registration");
  clients_.add(name.c_str(), pid_in(registration));
  log_.debug(std::string(name.c_str()) + " registers");
  IpcMessage as_member;
  for (std::uint32_t i = 0; i < 6; ++i)
    as_member << (i == 3 ? std::to_string(groups_.member) : registration.getElementAtIndex(i));
  RouDi::processMessage(as_member, IpcMessageType::REG, name);
}

/// Refuses a request beyond the limits, with the same answer that iceoryx gives if its own tables are full.
bool RoudiHost::refuse_over_limit(const IpcMessageType& type, const iox::RuntimeName_t& name) {
  const std::string reason = over_limit(type, name);
  if (reason.empty()) return false;
  log_.warning(std::string(name.c_str()) + " asked for more than a limit allows: " + reason);
  IpcMessage answer;
  answer << iox::runtime::IpcMessageTypeToString(IpcMessageType::ERROR) << reason;
  send_to(name.c_str(), answer.getMessage());
  return true;
}

/// Returns the error for the answer, or nothing if the request is within the limits.
std::string RoudiHost::over_limit(const IpcMessageType& type, const iox::RuntimeName_t& name) {
  const auto its_ports = [&name](const auto& ports) {
    return std::count_if(ports.begin(), ports.end(),
                         [&](const auto* port) { return port->m_runtimeName == name; });
  };
  if (type == IpcMessageType::REG && clients_.size() >= limits_.processes) return too_many_processes;
  if (type == IpcMessageType::CREATE_PUBLISHER) {
    const auto nobody_changes_ports = m_prcMgr.getScopeGuard();
    if (its_ports(port_pool_.getPublisherPortDataList()) >= limits_.publishers_per_process)
      return iox::runtime::IpcMessageErrorTypeToString(IpcMessageErrorType::PUBLISHER_LIST_FULL);
  }
  if (type == IpcMessageType::CREATE_SUBSCRIBER) {
    const auto nobody_changes_ports = m_prcMgr.getScopeGuard();
    if (its_ports(port_pool_.getSubscriberPortDataList()) >= limits_.subscribers_per_process)
      return iox::runtime::IpcMessageErrorTypeToString(IpcMessageErrorType::SUBSCRIBER_LIST_FULL);
  }
  return {};
}

void RoudiHost::cyclicUpdateHook() noexcept {
  if (!hooks_may_run_) return;
  bool removed = false;
  for (const std::string& name : clients_.find_dead(ClientTable::Clock::now())) removed |= remove_dead(name);
  if (removed) note_ports();
  forget_past_services(ports_);
  audit_chunks();
  note_usage();
}

/// No chunk is lost as long as no process has died. After a process has died, the chunks are checked again
/// and again, because a chunk that a killed reader had in hand can be found only when the writer of the
/// chunk is gone.
void RoudiHost::audit_chunks() {
  const auto now = std::chrono::steady_clock::now();
  if (deaths_ == 0 || (unaudited() == 0 && now < next_audit_)) return;
  const auto nobody_changes_ports = m_prcMgr.getScopeGuard();
  const auto [finding, freed] = auditor_.audit();
  if (finding == ChunkAuditor::Finding::damaged) return log_damage();
  if (finding == ChunkAuditor::Finding::busy) return;
  unaudited_ = 0;
  next_audit_ = now + audit_interval;
  leaks_healed_ += freed;
  if (freed > 0) log_.info("freed " + std::to_string(freed) + " chunks that killed programs had in hand");
}

/// A damaged list cannot be repaired. The daemon starts afresh once no program uses its memory, as it does
/// after a death whose lost chunks it cannot find.
void RoudiHost::log_damage() {
  if (std::exchange(damage_reported_, true)) return;
  if (unaudited() == 0) ++unaudited_;
  log_.warning(
      "a list of free chunks in shared memory is damaged: chunks are missing, and one may be lent twice; end "
      "sftd (sftd stop), and start it again or let programs start it: they meet in new memory");
}

bool RoudiHost::remove_dead(const std::string& name) {
  if (!lock_recovery_.recover())
    return false;  // a dead process's lock may still be closed; the next attempt is in 100 ms
  clients_.remove(name);
  {
    const iox::RuntimeName_t runtime_name(iox::cxx::TruncateToCapacity, name);
    m_prcMgr.getScopeGuard()->unregisterProcess(runtime_name);
  }
  remove_socket("/tmp/" + name);
  ++deaths_;
  ++unaudited_;
  log_.info(name + " is dead; its chunks and ports are free again");
  return true;
}

void RoudiHost::note_ports() {
  const auto nobody_changes_ports = m_prcMgr.getScopeGuard();
  lock_recovery_.note_ports();
  auditor_.note_ports();
}

void RoudiHost::note_usage() {
  Usage usage;
  {
    const auto nobody_changes_ports = m_prcMgr.getScopeGuard();
    usage = monitor_.look();
  }
  for (const ClientTable::Client& client : clients_.all()) {
    const auto of_client = [&client](const auto& port) { return port.user == client.name; };
    usage.users.push_back({client.pid, client.name,
                           static_cast<std::uint32_t>(std::ranges::count_if(usage.publishers, of_client)),
                           static_cast<std::uint32_t>(std::ranges::count_if(usage.subscribers, of_client))});
  }
  usage.leaks_healed = leaks_healed_;
  usage.locks_healed = lock_recovery_.opened();
  usage.deaths = deaths_;
  usage.unaudited = unaudited();
  usage.stamp_ns = core::realtime_ns();
  const core::Lock lock(usage_mutex_);
  usage_ = std::move(usage);
}

Usage RoudiHost::usage() const {
  const core::Lock lock(usage_mutex_);
  return usage_;
}

void RoudiHost::heal_until_stopped() {
  core::Lock lock(mutex_);
  for (;;) {
    const auto next_look = std::chrono::steady_clock::now() + healing_interval;
    while (!stopping_ && stop_.wait_until(lock, next_look)) continue;
    if (stopping_) return;
    lock.unlock();
    lock_recovery_.recover();
    lock.lock();
  }
}

}  // namespace sft::shm
