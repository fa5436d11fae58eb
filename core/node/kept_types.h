// Types that are known only at run time, kept as long as the node: what publishes, sends and remembers refers
// to them. Any thread.
#pragma once

#include <map>
#include <mutex>
#include <string>

#include "sft/dynamic_type.h"

namespace sft::core {

class KeptTypes {
 public:
  /// The same type for the same description, always.
  const TypeSupport& keep(const DynamicType& type) {
    const std::span<const std::byte> bytes = type.description();
    const std::string description(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::scoped_lock lock(mutex_);
    return by_description_.try_emplace(description, type).first->second.support();
  }

 private:
  std::mutex mutex_;
  std::map<std::string, DynamicType> by_description_;  ///< guarded by mutex_
};

}  // namespace sft::core
