#include "shm_transport/sftd/iceoryx_errors.h"

#include <utility>

namespace sft::shm {

IceoryxErrors::IceoryxErrors(const Log& log)
    : log_(log),
      handler_(iox::ErrorHandler::setTemporaryErrorHandler(
          [this](const iox::Error error, const std::function<void()>&, const iox::ErrorLevel level) {
            report(error, level);
          })) {}

void IceoryxErrors::end_process_with(EndProcess end) {
  const core::Lock lock(mutex_);
  end_ = std::move(end);
}

void IceoryxErrors::report(const iox::Error error, const iox::ErrorLevel level) {
  const std::string text = std::string("iceoryx reports ") + iox::ErrorHandler::toString(error);
  const bool moderate = level == iox::ErrorLevel::MODERATE;
  log_.write(moderate ? LogLevel::debug : LogLevel::warning, text);
  const core::Lock lock(mutex_);
  if (!moderate && end_) end_(text);
}

}  // namespace sft::shm
