// Products of exchange areas with vectors can be shared by ranks: each sweeps its part of the directions. Sums are
// whole numbers, so that they have the same bits for any number of ranks.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include <viewpeel/solve.h>
#include "engines/exchange_products.h"
#include "ranks/crew.h"
#include "ranks/message.h"

namespace viewpeel {

// Has all ranks sum the products of rank 0.
//   In: crew, products: the caller keeps the crew as long as the products; options: of the products; ids, enclosure:
//     before rows are split
//   Throws: errors of other ranks.
void shareProducts(Crew& crew, ExchangeProducts& products, const LatticeOptions& options, const Ids& ids,
                   const Enclosure& enclosure);

// A ProductServer answers what shareProducts() of rank 0 asks.
class ProductServer {
 public:
  //   In: scene: kept by reference; threads: 0: one for each core; stop: called before each direction, may throw
  ProductServer(const Scene& scene, uint32_t threads, std::function<void()> stop);
  ~ProductServer();

  // In: work: open_products or sum_products    Throws: what `stop` throws; Error limit for sums before products.
  std::string answer(RankWork work, MessageReader& in);

 private:
  std::string open(MessageReader& in);
  std::string sum(MessageReader& in);

  const Scene& scene_;
  uint32_t threads_;
  std::function<void()> stop_;
  Ids ids_;
  std::unique_ptr<ExchangeProducts> products_;
};

}  // namespace viewpeel
