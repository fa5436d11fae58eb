// Receives the errors that iceoryx reports in the daemon.
//
// While the daemon starts, an error must end the process: iceoryx would continue without the memory, files
// or sockets that it could not get, and crash. After the start, each error concerns one client, which gets
// an answer. So the error is only logged.
#pragma once

#include <functional>
#include <string>

#include "core/sync/mutex.h"
#include "shm_transport/host/iceoryx.h"
#include "shm_transport/sftd/log.h"

namespace sft::shm {

/// Only one object may exist at a time, because iceoryx has one error handler for each process.
class IceoryxErrors {
 public:
  using EndProcess = std::function<void(const std::string& error)>;

  /// `log` must outlive this object.
  explicit IceoryxErrors(const Log& log);
  IceoryxErrors(const IceoryxErrors&) = delete;
  IceoryxErrors& operator=(const IceoryxErrors&) = delete;

  /// Sets the function that ends the process at an error; empty: errors are only logged. Any thread may
  /// call this.
  void end_process_with(EndProcess end);

 private:
  void report(iox::Error error, iox::ErrorLevel level);

  const Log& log_;
  core::Mutex mutex_;
  EndProcess end_ SFT_GUARDED_BY(mutex_){};
  iox::cxx::GenericRAII handler_;
};

}  // namespace sft::shm
