#include "core/thread.h"

#include <pthread.h>

#include <csignal>
#include <system_error>
#include <utility>

namespace sft::core {

namespace {

/// New threads inherit the mask that is in force when they start.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    ::sigfillset(&all);
    // Those that a thread brings on itself stay: blocked they would end the process past its crash handler.
    for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGSYS, SIGABRT})
      ::sigdelset(&all, fault);
    ::pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;
  ~BlockedSignals() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

 private:
  sigset_t before_;
};

}  // namespace

Result<std::thread> start_thread(const std::string& name, std::function<void()> body) {
  const BlockedSignals blocked;
  try {
    return std::thread([name = name.substr(0, 15), body = std::move(body)] {
      ::pthread_setname_np(::pthread_self(), name.c_str());
      body();
    });
  } catch (const std::system_error& error) {
    return fail(Errc::system,
                "cannot start the thread " + name + ": " + error.what() + "; raise the limit (ulimit -u)");
  }
}

}  // namespace sft::core
