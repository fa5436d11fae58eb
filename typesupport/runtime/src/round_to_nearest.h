// Sets the rounding of floating-point numbers while text is read or written.
#pragma once

#include <cfenv>

namespace sft {

/// While this object exists, its thread rounds to the nearest number, whatever rounding mode the program
/// has chosen (fesetround). In another mode, a number could change if it is written and read back.
class RoundToNearest {
 public:
  RoundToNearest() noexcept {
    if (before_ != FE_TONEAREST) std::fesetround(FE_TONEAREST);
  }
  ~RoundToNearest() {
    if (before_ != FE_TONEAREST) std::fesetround(before_);
  }
  RoundToNearest(const RoundToNearest&) = delete;
  RoundToNearest& operator=(const RoundToNearest&) = delete;

 private:
  const int before_ = std::fegetround();
};

}  // namespace sft
