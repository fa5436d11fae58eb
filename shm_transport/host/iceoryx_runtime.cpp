#include "shm_transport/host/iceoryx_runtime.h"

namespace sft::shm {

/// iceoryx's own error handler would terminate the process at errors that are also returned to the caller.
/// So it is replaced by a handler that does nothing.
IceoryxRuntime::IceoryxRuntime()
    : error_handler_(iox::ErrorHandler::setTemporaryErrorHandler(
          [](iox::Error, const std::function<void()>&, iox::ErrorLevel) {})) {
  iox::log::LogManager::GetLogManager().SetDefaultLogLevel(iox::log::LogLevel::kOff,
                                                           iox::log::LogLevelOutput::kHideLogLevel);
}

bool IceoryxRuntime::announce_segment(std::uint64_t id, std::span<std::byte> memory) noexcept {
  const core::Lock lock(segments_mutex_);
  return iox::rp::BaseRelativePointer::registerPtr(id, memory.data(), memory.size());
}

void IceoryxRuntime::withdraw_segment(std::uint64_t id) noexcept {
  const core::Lock lock(segments_mutex_);
  iox::rp::BaseRelativePointer::unregisterPtr(id);
}

}  // namespace sft::shm
