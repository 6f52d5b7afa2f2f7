// SPDX-License-Identifier: GPL-3.0-or-later
#include "web/coded_assets.h"

#include "gaussian/stored_blocks.h"

namespace livegs {

Result<CodedAssets::Coded> CodedAssets::get(const std::string& name, std::span<const std::byte> progressive,
                                            uint64_t from, ContentCoding coding) {
  const std::string key = name + ' ' + std::string(name_of(coding));
  if (from == 0) {
    for (auto one = kept_.begin(); one != kept_.end(); ++one) {
      if (one->key != key) continue;
      kept_.splice(kept_.begin(), kept_, one);
      return one->coded;
    }
  }
  auto stored = store_blocks(progressive);
  if (!stored) return stored.error();
  if (from > stored->size())
    return invalid_argument("from: is past the end of the asset; use at most " +
                            std::to_string(stored->size()));
  auto coded = encode_content(std::span(*stored).subspan(from), coding);
  if (!coded) return coded.error();
  Coded made{std::make_shared<const std::vector<std::byte>>(*std::move(coded)), stored->size()};
  if (from == 0 && made.bytes->size() <= kMaxKeptAssets) {
    kept_.push_front({key, made});
    kept_bytes_ += made.bytes->size();
    while (kept_bytes_ > kMaxKeptAssets) {
      kept_bytes_ -= kept_.back().coded.bytes->size();
      kept_.pop_back();
    }
  }
  return made;
}

}  // namespace livegs
