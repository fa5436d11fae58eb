// Runs RouDi, the daemon of iceoryx, in this process. It differs from iceoryx's own daemon where that
// daemon is not safe if programs are killed or paused:
// - A process counts as dead when it has ended, and not when it was silent for 1.5 s. A debugger may have
//   stopped it.
// - Locks that killed publishers left closed are opened (lock_recovery.h).
// - Chunks that killed programs had in hand are freed (chunk_auditor.h).
// - The daemon never kills a process, and errors of one client do not end the daemon.
//
// Threads: the two threads of RouDi (discovery every 100 ms, messages of clients), and one that opens
// locks.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "core/sync/mutex.h"
#include "shm_transport/sftd/chunk_auditor.h"
#include "shm_transport/sftd/client_table.h"
#include "shm_transport/sftd/groups.h"
#include "shm_transport/sftd/host_memory.h"
#include "shm_transport/sftd/lock_recovery.h"
#include "shm_transport/sftd/log.h"
#include "shm_transport/sftd/settings.h"
#include "shm_transport/sftd/usage_monitor.h"

#include <iceoryx_posh/internal/roudi/port_manager.hpp>
#include <iceoryx_posh/internal/roudi/roudi.hpp>

namespace sft::shm {

/// A thread of RouDi calls the hooks below as soon as RouDi is constructed, before the derived object
/// exists. This base class is constructed before RouDi, so its flag already exists then.
class HookGate {
 protected:
  std::atomic<bool> hooks_may_run_{false};
};

class RoudiHost final : private HookGate, public iox::roudi::RouDi {
 public:
  /// `memory`, `ports` and `log` must outlive this object.
  RoudiHost(HostMemory& memory, iox::roudi::PortManager& ports, const Groups& groups, const Limits& limits,
            const Log& log);
  ~RoudiHost() override;

  /// Returns whether no process is registered.
  bool is_idle() const { return clients_.empty(); }
  /// Returns the processes that are registered.
  std::vector<ClientTable::Client> clients() const { return clients_.all(); }

  /// Returns the number of processes that died without a goodbye since the last audit of the chunks. Each
  /// of them may have lost a chunk that it had in hand.
  std::uint64_t unaudited() const { return unaudited_.load(std::memory_order_relaxed); }

  /// Returns the usage at the last measurement by RouDi's thread, which measures every 100 ms. Any thread
  /// may call this.
  Usage usage() const;

 private:
  void processMessage(const iox::runtime::IpcMessage& message, const iox::runtime::IpcMessageType& type,
                      const iox::RuntimeName_t& name) noexcept override;
  void cyclicUpdateHook() noexcept override;
  bool refuse_over_limit(const iox::runtime::IpcMessageType& type, const iox::RuntimeName_t& name);
  std::string over_limit(const iox::runtime::IpcMessageType& type, const iox::RuntimeName_t& name);
  void register_client(const iox::runtime::IpcMessage& registration, const iox::RuntimeName_t& name);
  bool remove_dead(const std::string& name);
  void audit_chunks();
  void log_damage();
  void note_ports();
  void note_usage();
  void heal_until_stopped();

  const Groups groups_;
  const Limits limits_;
  const Log& log_;
  iox::roudi::PortManager& ports_;
  iox::roudi::PortPool& port_pool_;
  ClientTable clients_;
  LockRecovery lock_recovery_;
  ChunkAuditor auditor_;  ///< used while RouDi's lock on its processes is held
  UsageMonitor monitor_;  ///< used while RouDi's lock on its processes is held
  // The following members are used by the discovery thread of RouDi. Other threads read only `unaudited_`.
  std::uint64_t deaths_ = 0;
  std::atomic<std::uint64_t> unaudited_{0};
  std::uint64_t leaks_healed_ = 0;
  std::chrono::steady_clock::time_point next_audit_{};
  bool damage_reported_ = false;

  mutable core::Mutex usage_mutex_;
  Usage usage_ SFT_GUARDED_BY(usage_mutex_);

  core::Mutex mutex_;
  core::Condition stop_;
  bool stopping_ SFT_GUARDED_BY(mutex_) = false;
  std::thread healing_;
};

}  // namespace sft::shm
