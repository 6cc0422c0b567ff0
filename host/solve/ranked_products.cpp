#include "solve/ranked_products.h"

#include <utility>

#include "engines/ranked_engine.h"
#include "ranks/put_ids.h"
#include "solve/split_rows.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

// These two write and read what splits rows by the angle: emissivities and laws.
void putDirections(MessageWriter& out, const Enclosure& enclosure) {
  out.put(uint64_t(enclosure.laws.size()));
  for (const DirectionalLaw& law : enclosure.laws) out.put(law.cosine_power).putAll(law.angles_deg).putAll(law.values);
  if (enclosure.laws.empty()) return;
  for (const Material& material : enclosure.materials) out.put(material.emissivity).put(material.directional);
}
Enclosure getDirections(MessageReader& in, uint32_t rows) {
  Enclosure enclosure;
  enclosure.materials.resize(rows);
  enclosure.laws.resize(in.get<uint64_t>());
  for (DirectionalLaw& law : enclosure.laws) {
    law.cosine_power = in.get<double>();
    law.angles_deg = in.getAll<double>(), law.values = in.getAll<double>();
  }
  if (enclosure.laws.empty()) return enclosure;
  for (Material& material : enclosure.materials) {
    material.emissivity = in.get<double>();
    material.directional = in.get<std::optional<uint32_t>>();
  }
  return enclosure;
}

ExchangeProducts::Sums getSums(MessageReader& in) {
  ExchangeProducts::Sums sums;
  sums.products = in.getAll<WideInteger>();
  sums.outside = in.getAll<std::array<WideInteger, 4>>();
  return sums;
}

}  // namespace

void shareProducts(Crew& crew, ExchangeProducts& products, const LatticeOptions& options, const Ids& ids,
                   const Enclosure& enclosure) {
  MessageWriter out;
  out.put(RankWork::open_products);
  putLattice(out, options);
  putIds(out, ids);
  putDirections(out, enclosure);
  const std::string message = out.take();
  crew.share([&](uint32_t) { return message; }, [] {});
  products.sumBy([&crew, &products](std::span<const Direction> directions, std::span<const int64_t> factors,
                                    size_t columns, bool counts_outside) {
    const std::vector<size_t> cuts = crew.cutEvenly(directions.size());
    const auto partOf = [&](size_t rank) { return directions.subspan(cuts[rank], cuts[rank + 1] - cuts[rank]); };
    ExchangeProducts::Sums sums;
    const std::vector<std::string> answers = crew.share(
        [&](uint32_t rank) {
          MessageWriter question;
          question.put(RankWork::sum_products).put(uint64_t(columns)).put(counts_outside);
          return question.putAll(partOf(rank)).putAll(factors).take();
        },
        [&] { sums = products.sum(partOf(0), factors, columns, counts_outside); });
    for (const std::string& answer : answers) {
      MessageReader in(answer);
      sums.add(getSums(in));
    }
    return sums;
  });
}

ProductServer::ProductServer(const Scene& scene, uint32_t threads, std::function<void()> stop)
    : scene_(scene), threads_(threads), stop_(std::move(stop)) {}

ProductServer::~ProductServer() = default;

std::string ProductServer::answer(RankWork work, MessageReader& in) {
  return work == RankWork::open_products ? open(in) : sum(in);
}

std::string ProductServer::open(MessageReader& in) {
  LatticeOptions options = getLattice(in);
  options.thread_count = threads_;
  options.stop = stop_;
  options.on_batch = [this](uint64_t) { stop_(); };
  products_.reset();
  ids_ = getIds(in);
  SplitRows rows = splitRows(scene_, ids_, getDirections(in, ids_.count()));
  products_ = rows.shares ? std::make_unique<ExchangeProducts>(scene_, std::move(*rows.shares), options)
                          : std::make_unique<ExchangeProducts>(scene_, ids_, options);
  return {};
}

std::string ProductServer::sum(MessageReader& in) {
  if (!products_) throw Error(ErrorCode::limit, "rank 0 asked for products of a scene that was not opened");
  const auto columns = in.get<uint64_t>();
  const auto counts_outside = in.get<bool>();
  const std::vector<Direction> directions = in.getAll<Direction>();
  const std::vector<int64_t> factors = in.getAll<int64_t>();
  const ExchangeProducts::Sums sums = products_->sum(directions, factors, columns, counts_outside);
  return MessageWriter().putAll(sums.products).putAll(sums.outside).take();
}

}  // namespace viewpeel
