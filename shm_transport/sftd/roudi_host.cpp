#include "shm_transport/sftd/roudi_host.h"

#include <charconv>

#include "shm_transport/host_file.h"
#include "shm_transport/sftd/stale_files.h"

namespace sft::shm {

using iox::runtime::IpcMessage;
using iox::runtime::IpcMessageType;

namespace {

constexpr std::chrono::milliseconds healing_interval{20};
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

}  // namespace

RoudiHost::RoudiHost(HostMemory& memory, iox::roudi::PortManager& ports, const Log& log)
    : RouDi(memory, ports, startup_parameters()),
      log_(log),
      healer_(*memory.portPool().value(), clients_, log),
      reclaimer_(*memory.portPool().value()) {
  hooks_may_run_ = true;
  healing_ = std::thread([this] { heal_until_stopped(); });
  startProcessRuntimeMessagesThread();
}

RoudiHost::~RoudiHost() {
  shutdown();
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  stop_.notify_one();
  healing_.join();
}

void RoudiHost::processMessage(const IpcMessage& message, const IpcMessageType& type,
                               const iox::RuntimeName_t& name) noexcept {
  // From anybody who may write to the socket. The name becomes a path, which iceoryx writes to and which is
  // removed once nobody listens there.
  if (!is_runtime_name(name.c_str())) return log_.debug("a message under a name that no program of ours has");
  if (type == IpcMessageType::REG && message.getNumberOfElements() == 6) {
    clients_.add(name.c_str(), pid_in(message));
    log_.debug(std::string(name.c_str()) + " registers");
  }
  if (type == IpcMessageType::TERMINATION) {
    // Its ports are about to be destroyed, which iceoryx survives only if their locks are open.
    clients_.remove(name.c_str());
    for (int i = 0; i < goodbye_looks_max && !healer_.heal(); ++i)
      std::this_thread::sleep_for(healing_interval);
    log_.debug(std::string(name.c_str()) + " says goodbye");
  }
  RouDi::processMessage(message, type, name);
  if (type != IpcMessageType::REG) note_ports();
}

void RoudiHost::cyclicUpdateHook() noexcept {
  if (!hooks_may_run_) return;
  bool buried = false;
  for (const std::string& name : clients_.find_dead(ClientTable::Clock::now())) buried |= bury(name);
  if (buried) note_ports();
  reclaim_chunks();
}

void RoudiHost::reclaim_chunks() {
  const auto nobody_changes_ports = m_prcMgr.getScopeGuard();
  const std::size_t chunks = reclaimer_.reclaim();
  if (chunks > 0)
    log_.info(std::to_string(chunks) + " chunks that killed programs were delivering are free again");
}

bool RoudiHost::bury(const std::string& name) {
  if (!healer_.heal()) return false;  // a lock of the dead may still be closed; again in 100 ms
  clients_.remove(name);
  {
    const iox::RuntimeName_t runtime_name(iox::cxx::TruncateToCapacity, name);
    auto processes = m_prcMgr.getScopeGuard();
    reclaimer_.note_deliveries(runtime_name);
    processes->unregisterProcess(runtime_name);
  }
  remove_socket("/tmp/" + name);
  ++deaths_;
  log_.info(name + " is dead; what it had is free again");
  return true;
}

void RoudiHost::note_ports() {
  const auto nobody_changes_ports = m_prcMgr.getScopeGuard();
  healer_.note_ports();
}

void RoudiHost::heal_until_stopped() {
  std::unique_lock lock(mutex_);
  while (!stop_.wait_for(lock, healing_interval, [this] { return stopping_; })) {
    lock.unlock();
    healer_.heal();
    lock.lock();
  }
}

}  // namespace sft::shm
