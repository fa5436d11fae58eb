#include "tools/demo/screen/wait_notice.h"

#include <fmt/format.h>

namespace sft::demo {

std::optional<std::string> WaitNotice::line(std::string_view what, Clock::time_point now) {
  if (what != what_) {
    what_ = what;
    since_ = said_ = now;
    return fmt::format("{} ...", what_);
  }
  if (now - said_ < interval) return std::nullopt;
  said_ = now;
  return fmt::format("{} ... {} s", what_, std::chrono::floor<std::chrono::seconds>(now - since_).count());
}

}  // namespace sft::demo
