// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <thread>

#include "common/gaussian/synthetic_asset.h"
#include "core/content_hash.h"
#include "core/file.h"
#include "gaussian/asset_file.h"
#include "gaussian/progressive_asset.h"
#include "scratch_folder.h"
#include "stream/received/asset_cache.h"

namespace livegs {
namespace {

// Sends an asset in pieces of 1000 bytes, optionally interrupted.
class Source {
 public:
  // `kernels` of up to 56 bytes each.
  explicit Source(size_t kernels)
      : asset(synthetic_asset(kernels, 0, 7)), ply(encode_ply(asset)), bytes(encode_progressive(asset)) {
    hash = content_hash(ply);
  }
  AssetCache::Fetch fetch(size_t cut_after = ~size_t{0}) {
    return [this, cut_after](uint64_t offset, const TakeChunk& take) -> Result<void> {
      offsets.push_back(offset);
      size_t sent = 0;
      for (size_t at = offset; at < bytes.size(); at += 1000) {
        if (sent >= cut_after) return Error{ErrorCode::Unavailable, "cut"};
        const size_t length = std::min<size_t>(1000, bytes.size() - at);
        if (auto taken = take(at, bytes.size(), std::span(bytes).subspan(at, length)); !taken) return taken;
        sent += length;
      }
      return {};
    };
  }
  const GaussianAsset asset;
  const std::vector<std::byte> ply;  // file in the cache
  std::vector<std::byte> bytes;      // bytes on the wire
  std::string hash;
  std::vector<uint64_t> offsets;
};

TEST(AssetCache, FetchesOnceThenReadsFromCache) {
  const ScratchFolder folder;
  const AssetCache cache(folder / "cache");
  Source source(100);
  const auto first = cache.obtain(source.hash, source.bytes.size(), source.fetch());
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_EQ(first->bytes, source.ply);
  EXPECT_EQ(first->fetched_bytes, source.bytes.size());
  const auto second = cache.obtain(source.hash, source.bytes.size(), source.fetch());
  ASSERT_TRUE(second) << second.error().message;
  EXPECT_EQ(second->bytes, source.ply);
  EXPECT_EQ(second->fetched_bytes, 0u);
  EXPECT_EQ(source.offsets.size(), 1u);
}

TEST(AssetCache, ResumesInterruptedTransfer) {
  const ScratchFolder folder;
  const AssetCache cache(folder / "cache");
  Source source(100);
  ASSERT_FALSE(cache.obtain(source.hash, source.bytes.size(), source.fetch(3000)));
  const auto rest = cache.obtain(source.hash, source.bytes.size(), source.fetch());
  ASSERT_TRUE(rest) << rest.error().message;
  EXPECT_EQ(rest->bytes, source.ply);
  EXPECT_EQ(rest->fetched_bytes, source.bytes.size() - 3000);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "cache" / (source.hash + ".part")));
  EXPECT_EQ(source.offsets, (std::vector<uint64_t>{0, 3000}));
}

TEST(AssetCache, RefetchesWrongPartFromStart) {
  const ScratchFolder folder;
  Source source(100);
  folder.write("cache/" + source.hash + ".part", std::string(2000, 'x'));
  const AssetCache cache(folder / "cache");
  const auto whole = cache.obtain(source.hash, source.bytes.size(), source.fetch());
  ASSERT_TRUE(whole) << whole.error().message;
  EXPECT_EQ(whole->bytes, source.ply);
  EXPECT_EQ(source.offsets, (std::vector<uint64_t>{0}));
}

TEST(AssetCache, RefetchesDamagedFile) {
  const ScratchFolder folder;
  Source source(100);
  folder.write("cache/" + source.hash + ".ply", std::string(4500, 'x'));
  const AssetCache cache(folder / "cache");
  const auto whole = cache.obtain(source.hash, source.bytes.size(), source.fetch());
  ASSERT_TRUE(whole) << whole.error().message;
  EXPECT_EQ(whole->fetched_bytes, source.bytes.size());
  EXPECT_EQ(*read_file(folder.path() / "cache" / (source.hash + ".ply")), source.ply);
}

TEST(AssetCache, RefusesBytesWithDifferentHash) {
  const ScratchFolder folder;
  const AssetCache cache(folder / "cache");
  Source source(100);
  source.bytes = encode_progressive(synthetic_asset(100, 0, 8));
  const auto refused = cache.obtain(source.hash, source.bytes.size(), source.fetch());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::InvalidData);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "cache" / (source.hash + ".ply")));
}

// Reported at the damaged block, before the rest is fetched.
TEST(AssetCache, RefusesBytesThatAreNotAnAsset) {
  const ScratchFolder folder;
  const AssetCache cache(folder / "cache");
  Source source(9000);
  source.bytes[300] ^= std::byte{1};
  const auto refused = cache.obtain(source.hash, source.bytes.size(), source.fetch());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::InvalidData);
  EXPECT_EQ(refused.error().message.find("asset " + source.hash.substr(0, 12) + ": a block"), 0u)
      << refused.error().message;
  EXPECT_EQ(source.offsets.size(), 1u);
}

// Progress is reported during the transfer, also for data of an earlier attempt.
TEST(AssetCache, ReportsDrawablePartsDuringTransfer) {
  const ScratchFolder folder;
  const AssetCache cache(folder / "cache");
  Source source(9000);
  std::vector<size_t> kernels;
  const auto note_part = [&](const ProgressiveDecoder& so_far) {
    kernels.push_back(so_far.part().asset.size());
  };
  const size_t most = source.bytes.size() * 6 / 10;
  ASSERT_FALSE(cache.obtain(source.hash, source.bytes.size(), source.fetch(most), note_part));
  EXPECT_EQ(kernels, (std::vector<size_t>{1024, 3072}));
  kernels.clear();
  const auto whole = cache.obtain(source.hash, source.bytes.size(), source.fetch(), note_part);
  ASSERT_TRUE(whole) << whole.error().message;
  EXPECT_EQ(kernels, (std::vector<size_t>{3072, 7168, 9000}));
  EXPECT_EQ(whole->bytes, source.ply);
  EXPECT_LE(whole->fetched_bytes, source.bytes.size() - most);
}

// A store that fails, ends early, or has other bytes: the server completes the transfer.
TEST(AssetCache, FetchesFromTheServerWhatAStoreDoesNotGive) {
  Source source(100), other(300);
  ASSERT_NE(other.bytes.size(), source.bytes.size());
  const std::map<std::string, AssetCache::Fetch> stores{
      {"refuses", [](uint64_t, const TakeChunk&) { return Result<void>(not_found("status 404")); }},
      {"fails after 3000 bytes", source.fetch(3000)},
      {"another asset", other.fetch()},
      {"ends without a byte", [](uint64_t, const TakeChunk&) { return Result<void>(); }}};
  for (const auto& [name, store] : stores) {
    const ScratchFolder folder;
    const AssetCache cache(folder / "cache");
    std::vector<uint64_t> asked;
    const auto server = [&](uint64_t offset, const TakeChunk& take) {
      asked.push_back(offset);
      return source.fetch()(offset, take);
    };
    const std::vector<AssetCache::Fetch> sources{store, server};
    const auto whole = cache.obtain(source.hash, source.bytes.size(), sources);
    ASSERT_TRUE(whole) << name << ": " << whole.error().message;
    EXPECT_EQ(whole->bytes, source.ply) << name;
    if (name.starts_with("fails")) EXPECT_EQ(asked, std::vector<uint64_t>{3000});
  }
  const ScratchFolder folder;
  const AssetCache cache(folder / "cache");
  const std::vector<AssetCache::Fetch> sources{source.fetch(), [](uint64_t, const TakeChunk&) {
                                                 ADD_FAILURE() << "the server is asked";
                                                 return Result<void>();
                                               }};
  EXPECT_TRUE(cache.obtain(source.hash, source.bytes.size(), sources));
}

// An edit of an asset that the client has replaces the transfer, unless its bytes are wrong.
TEST(AssetCache, FetchesAnEditOfAnEarlierAsset) {
  Source source(2000);
  const auto base = std::make_shared<GaussianAsset>(source.asset);
  base->resize(1990);
  const auto edit = encode_edit(*base, source.asset);
  ASSERT_TRUE(edit);
  const auto sends = [](std::vector<std::byte> bytes) -> AssetCache::Fetch {
    return [bytes = std::move(bytes)](uint64_t offset, const TakeChunk& take) {
      return take(offset, bytes.size(), bytes);
    };
  };
  const std::vector<AssetCache::Fetch> server{source.fetch()};
  {
    const ScratchFolder folder;
    const AssetCache cache(folder / "cache");
    const auto made =
        cache.obtain(source.hash, source.bytes.size(), server, {}, {}, {[&] { return base; }, sends(*edit)});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(made->bytes, source.ply);
    EXPECT_EQ(made->fetched_bytes, edit->size());
    EXPECT_LT(edit->size(), source.bytes.size() / 50);
    EXPECT_TRUE(source.offsets.empty()) << "the whole asset is not fetched";
    EXPECT_EQ(*read_file(folder.path() / "cache" / (source.hash + ".ply")), source.ply);
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "cache" / (source.hash + ".part")));
  }
  std::vector<std::byte> damaged = *edit;
  damaged.back() ^= std::byte{1};
  const Source other(2100);
  const std::map<std::string, AssetCache::Edit> failing{
      {"the base is missing", {[] { return nullptr; }, sends(*edit)}},
      {"the base is another asset",
       {[] { return std::make_shared<GaussianAsset>(synthetic_asset(1990, 0, 3)); }, sends(*edit)}},
      {"damaged", {[&] { return base; }, sends(damaged)}},
      {"another asset", {[&] { return base; }, sends(other.bytes)}},
      {"truncated", {[&] { return base; }, sends({edit->begin(), edit->begin() + 40})}},
      {"the server has none",
       {[&] { return base; },
        [](uint64_t, const TakeChunk&) { return Result<void>(not_found("base_hash")); }}}};
  for (const auto& [what, one] : failing) {
    const ScratchFolder folder;
    const AssetCache cache(folder / "cache");
    source.offsets.clear();
    const auto whole = cache.obtain(source.hash, source.bytes.size(), server, {}, {}, one);
    ASSERT_TRUE(whole) << what << ": " << whole.error().message;
    EXPECT_EQ(whole->bytes, source.ply) << what;
    EXPECT_EQ(source.offsets, std::vector<uint64_t>{0}) << what;
  }
}

TEST(AssetCache, RefusesExcessBytes) {
  const ScratchFolder folder;
  const AssetCache cache(folder / "cache");
  Source source(100);
  EXPECT_FALSE(cache.obtain(source.hash, 2000, source.fetch()));
  EXPECT_LE(std::filesystem::file_size(folder.path() / "cache" / (source.hash + ".part")), 2000u);
}

TEST(AssetCache, ConcurrentClientsFetchOnce) {
  const ScratchFolder folder;
  Source source(4000);
  std::vector<std::thread> clients;
  std::atomic<uint64_t> fetched{0};
  std::mutex source_mutex;  // the source is not thread-safe; the cache serialises the fetches
  for (int i = 0; i < 8; ++i) {
    clients.emplace_back([&] {
      const AssetCache cache(folder / "cache");
      const auto obtained =
          cache.obtain(source.hash, source.bytes.size(), [&](uint64_t offset, const TakeChunk& take) {
            std::lock_guard lock(source_mutex);
            return source.fetch()(offset, take);
          });
      ASSERT_TRUE(obtained) << obtained.error().message;
      EXPECT_EQ(obtained->bytes, source.ply);
      fetched += obtained->fetched_bytes;
    });
  }
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(fetched, source.bytes.size());
}

TEST(AssetCache, NamesFolderThatCannotBeCreated) {
  const ScratchFolder folder;
  const auto file = folder.write("file", "");
  Source source(1);
  const auto refused = AssetCache(file / "cache").obtain(source.hash, 10, source.fetch());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("--cache"), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace livegs
