#include "core/negotiation/remote_requests.h"

namespace sft::core {

bool RemoteRequests::adopt(Endpoint& reader, const Request& request) {
  const Request& known = reader.request;
  if (request.sequence <= known.sequence || request.sequence > request_sequence_max) return false;
  const bool is_jump = request.sequence - known.sequence > jump_max;
  if (is_jump && request.announcer != reader.announcer) return false;
  reader.request = request;
  return true;
}

void RemoteRequests::adopt_early(Endpoint& reader) {
  for (const Request& early : early_.take(reader.id, reader.announcer)) adopt(reader, early);
}

}  // namespace sft::core
