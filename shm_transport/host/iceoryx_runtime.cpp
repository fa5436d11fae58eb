#include "shm_transport/host/iceoryx_runtime.h"

#include <atomic>

namespace sft::shm {

namespace {

std::atomic<std::uint64_t> error_count{0};

void count_error(iox::Error, const std::function<void()>&, iox::ErrorLevel) { ++error_count; }

/// Replaces iceoryx's own handler, which would terminate the process at errors that the calls also return.
iox::cxx::GenericRAII install_error_handler() {
  static const iox::HandlerFunction handler = count_error;
  return iox::ErrorHandler::setTemporaryErrorHandler(handler);
}

}  // namespace

IceoryxRuntime::IceoryxRuntime() : error_handler_(install_error_handler()) {
  iox::log::LogManager::GetLogManager().SetDefaultLogLevel(iox::log::LogLevel::kOff,
                                                           iox::log::LogLevelOutput::kHideLogLevel);
}

bool IceoryxRuntime::announce_segment(std::uint64_t id, std::span<std::byte> memory) noexcept {
  const std::scoped_lock lock(segments_mutex_);
  return iox::rp::BaseRelativePointer::registerPtr(id, memory.data(), memory.size());
}

void IceoryxRuntime::withdraw_segment(std::uint64_t id) noexcept {
  const std::scoped_lock lock(segments_mutex_);
  iox::rp::BaseRelativePointer::unregisterPtr(id);
}

std::uint64_t IceoryxRuntime::errors() noexcept { return error_count; }

}  // namespace sft::shm
