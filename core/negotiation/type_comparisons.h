// Explains why two definitions of one type do not match. Results are kept, since the same pairs are
// evaluated again after every event. If there are too many, all results are dropped. Other processes may
// announce any number of definitions, so only a few are compared between two calls of refill().
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <tuple>

#include "core/control/control.h"
#include "sft/status.h"
#include "sft/type_support.h"

namespace sft::core {

class TypeComparisons {
 public:
  /// The maximum number of comparisons between two calls of refill(). Each may have 4096 fields and take
  /// half a millisecond.
  static constexpr int compared_at_once = 16;

  /// Returns the differences between the definitions; never null. The texts are empty if `theirs` has no
  /// description. They are also empty if the result is not known yet and no comparison is allowed before
  /// the next refill().
  std::shared_ptr<const TypeMismatch> compare(const TypeSupport& ours, const Endpoint& theirs);
  void refill() { left_ = compared_at_once; }
  /// Returns the number of definitions that were compared so far.
  std::uint64_t compared() const { return compared_; }

 private:
  /// The name of the type and the hashes of both definitions. (The hashes do not cover the names of types.)
  using Definitions = std::tuple<std::string, std::uint64_t, std::uint64_t>;

  std::map<Definitions, std::shared_ptr<const TypeMismatch>> known_;
  std::size_t bytes_ = 0;  ///< the size of these results in bytes
  int left_ = compared_at_once;
  std::uint64_t compared_ = 0;
};

}  // namespace sft::core
