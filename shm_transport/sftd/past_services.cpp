#include "shm_transport/sftd/past_services.h"

#include <mutex>

namespace sft::shm {

namespace {

using Introspection = iox::roudi::PortIntrospectionType;

/// Gives access to a private member of iceoryx's classes. This is possible because an explicit
/// instantiation of a template may name such a member.
template <class Name, auto member>
struct Opened {
  friend auto opened(Name) { return member; }
};

struct IntrospectionOfPorts {};
struct DataOfIntrospection {};
struct PublishersOfData {};
struct SubscribersOfData {};
struct MutexOfData {};
auto opened(IntrospectionOfPorts);
auto opened(DataOfIntrospection);
auto opened(PublishersOfData);
auto opened(SubscribersOfData);
auto opened(MutexOfData);
template struct Opened<IntrospectionOfPorts, &iox::roudi::PortManager::m_portIntrospection>;
template struct Opened<DataOfIntrospection, &Introspection::m_portData>;
template struct Opened<PublishersOfData, &Introspection::PortData::m_publisherMap>;
template struct Opened<SubscribersOfData, &Introspection::PortData::m_connectionMap>;
template struct Opened<MutexOfData, &Introspection::PortData::m_mutex>;

}  // namespace

void forget_past_services(iox::roudi::PortManager& ports) {
  auto& data = ports.*opened(IntrospectionOfPorts{}).*opened(DataOfIntrospection{});
  const auto has_no_port = [](const auto& service) { return service.second.empty(); };
  const std::scoped_lock lock(data.*opened(MutexOfData{}));
  std::erase_if(data.*opened(PublishersOfData{}), has_no_port);
  std::erase_if(data.*opened(SubscribersOfData{}), has_no_port);
}

}  // namespace sft::shm
