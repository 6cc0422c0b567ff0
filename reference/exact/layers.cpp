#include "reference/exact/layers.h"

#include <algorithm>
#include <utility>

namespace viewpeel::reference {

void Layers::assign(uint32_t outline) {
  layers_.assign(1, {outline, 0, false});
  change_.outline = outline;
  update();
}

void Layers::insert(uint32_t outline) {
  Layer added{outline, 0, order_.isBelow(outline, change_.outline)};
  for (Layer& layer : layers_) {
    if (order_.isBelow(layer.outline, outline)) ++added.below_count;
    else ++layer.below_count;
  }
  layers_.push_back(added);
  update();
}

void Layers::erase(uint32_t outline) {
  const auto isIt = [&](const Layer& layer) { return layer.outline == outline; };
  layers_.erase(std::find_if(layers_.begin(), layers_.end(), isIt));
  for (Layer& layer : layers_)
    if (order_.isBelow(outline, layer.outline)) --layer.below_count;
  update();
}

void Layers::update() {
  change_.lower = change_.upper = kNoOutline;
  change_.is_cyclic = false;
  change_.inside.clear();
  change_.outside.clear();
  findNeighbours();
  if (change_.is_cyclic) change_.lower = change_.upper = kNoOutline;
  if (change_.is_cyclic || lists_all_) listAll();
}

void Layers::findNeighbours() {
  taken_.assign(layers_.size(), false);
  const uint32_t outline_below_count = layers_.front().below_count;
  for (const Layer& layer : layers_) {
    if (std::exchange(taken_[layer.below_count], true)) change_.is_cyclic = true;
    if (layer.below_count + 1 == outline_below_count) change_.lower = layer.outline;
    if (layer.below_count == outline_below_count + 1) change_.upper = layer.outline;
  }
}

void Layers::listAll() {
  std::vector<std::pair<uint32_t, uint32_t>> inside, outside;  // below_count, outline
  for (const Layer& layer : layers_) {
    inside.emplace_back(layer.below_count, layer.outline);
    if (layer.outline != change_.outline)
      outside.emplace_back(layer.below_count - (layer.is_below_outline ? 0 : 1), layer.outline);
  }
  const auto list = [](auto& counted, std::vector<uint32_t>& result) {
    std::sort(counted.begin(), counted.end());
    result.push_back(kNoOutline);
    for (const auto& [count, outline] : counted) result.push_back(outline);
    result.push_back(kNoOutline);
  };
  list(inside, change_.inside);
  list(outside, change_.outside);
}

}  // namespace viewpeel::reference
