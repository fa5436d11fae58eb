// Somebody else withdraws or announces endpoints of ours, or requests something in their name. Such an
// endpoint is announced anew, with a revision and a request that are later than all that was said in its
// name. A copy of what we said ourselves costs nothing. Pure.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/control/control.h"

namespace sft::core {

class Contests {
 public:
  struct Contested {
    EndpointId id = 0;
    std::string how;  ///< text for the log
  };

  void announced(Endpoint& ours, const Endpoint& said);
  void withdrawn(Endpoint& ours);
  void requested(Endpoint& ours, const Request& said);

  /// Returns the endpoints that were contested since the last call.
  std::vector<Contested> take() { return std::exchange(contested_, {}); }

 private:
  void contest(Endpoint& ours, const Request& said, std::string how);

  std::vector<Contested> contested_;
};

}  // namespace sft::core
