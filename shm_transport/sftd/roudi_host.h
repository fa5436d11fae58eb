// iceoryx's RouDi in this process, changed where its own daemon is not safe under kills and pauses. A process
// is dead when it is dead, not when it was silent for 1.5 s (a debugger may stop it). Locks of killed
// publishers are opened (lock_healer.h), and chunks that killed programs had in hand are freed
// (chunk_auditor.h).
// It never kills anybody, and errors of one client do not end it.
//
// Threads: RouDi's two (discovery every 100 ms, messages of clients), and one that heals.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

#include "shm_transport/sftd/chunk_auditor.h"
#include "shm_transport/sftd/client_table.h"
#include "shm_transport/sftd/groups.h"
#include "shm_transport/sftd/host_memory.h"
#include "shm_transport/sftd/lock_healer.h"
#include "shm_transport/sftd/log.h"
#include "shm_transport/sftd/settings.h"
#include "shm_transport/sftd/usage_book.h"

#include <iceoryx_posh/internal/roudi/port_manager.hpp>
#include <iceoryx_posh/internal/roudi/roudi.hpp>

namespace sft::shm {

/// RouDi's thread calls the hooks below as soon as RouDi is constructed, when the derived object does not
/// exist yet. A base that comes before RouDi is there in time.
class HookGate {
 protected:
  std::atomic<bool> hooks_may_run_{false};
};

class RoudiHost final : private HookGate, public iox::roudi::RouDi {
 public:
  /// `memory`, `ports` and `log` outlive this.
  RoudiHost(HostMemory& memory, iox::roudi::PortManager& ports, const Groups& groups, const Limits& limits,
            const Log& log);
  ~RoudiHost() override;

  /// Whether no process is registered.
  bool is_idle() const { return clients_.empty(); }

  /// Processes that died without a goodbye since the chunks were last looked through. Of each, one may be
  /// lost that it had in hand.
  std::uint64_t unaudited() const { return unaudited_.load(std::memory_order_relaxed); }

  /// As RouDi's thread saw it at its last round, 100 ms ago at most if that goes on. Any thread.
  Usage usage() const;

 private:
  void processMessage(const iox::runtime::IpcMessage& message, const iox::runtime::IpcMessageType& type,
                      const iox::RuntimeName_t& name) noexcept override;
  void cyclicUpdateHook() noexcept override;
  bool refuse_over_limit(const iox::runtime::IpcMessageType& type, const iox::RuntimeName_t& name);
  std::string over_limit(const iox::runtime::IpcMessageType& type, const iox::RuntimeName_t& name);
  void take_on(const iox::runtime::IpcMessage& registration, const iox::RuntimeName_t& name);
  bool bury(const std::string& name);
  void audit_chunks();
  void note_ports();
  void note_usage();
  void heal_until_stopped();

  const Groups groups_;
  const Limits limits_;
  const Log& log_;
  iox::roudi::PortPool& port_pool_;
  ClientTable clients_;
  LockHealer healer_;
  ChunkAuditor auditor_;  ///< used under RouDi's lock on its processes
  UsageBook book_;        ///< likewise
  // Of RouDi's thread, and looked at by others.
  std::uint64_t deaths_ = 0;
  std::atomic<std::uint64_t> unaudited_{0};
  std::uint64_t leaks_healed_ = 0;
  std::chrono::steady_clock::time_point next_audit_{};

  mutable std::mutex usage_mutex_;  // guards usage_
  Usage usage_;

  std::mutex mutex_;  // guards stopping_
  std::condition_variable stop_;
  bool stopping_ = false;
  std::thread healing_;
};

}  // namespace sft::shm
