#include "ranks/put_ids.h"

namespace viewpeel {

void putIds(MessageWriter& out, const Ids& ids) {
  out.put(ids.count()).put(ids.counts_environment).put(ids.two_sided);
  out.putAll(ids.of_polygon).putAll(ids.roles).putAll(ids.areas).putAll(ids.surface);
  out.putAll(std::vector<char>(ids.requested.begin(), ids.requested.end()));
}

Ids getIds(MessageReader& in) {
  Ids ids;
  ids.names.resize(in.get<uint32_t>());
  ids.counts_environment = in.get<bool>(), ids.two_sided = in.get<bool>();
  ids.of_polygon = in.getAll<uint32_t>(), ids.roles = in.getAll<uint32_t>();
  ids.areas = in.getAll<double>(), ids.surface = in.getAll<uint32_t>();
  const std::vector<char> requested = in.getAll<char>();
  ids.requested.assign(requested.begin(), requested.end());
  return ids;
}

}  // namespace viewpeel
