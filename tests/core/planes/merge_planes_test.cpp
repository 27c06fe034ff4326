#include "core/planes/merge_planes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rigcal {
namespace {

// A piece of a floor, seen once from each of two stops.
PlaneFeature leaf(const Vector3d& center, double size_m, double offset_sigma_m) {
  PlaneFeature out;
  out.center_G = center;
  out.size_m = size_m;
  for (int stop = 0; stop < 2; ++stop) {
    PlaneObservation o;
    o.stop = stop;
    o.N = 100.0;
    o.mean = center;
    o.scatter = o.N * size_m * size_m / 12.0 * Vector3d(1.0, 1.0, 0.0).asDiagonal().toDenseMatrix();
    o.offset_variance = offset_sigma_m * offset_sigma_m;
    o.weight = 1.0 / (o.N * o.offset_variance);
    out.observations.push_back(o);
  }
  return out;
}

// Large pieces side by side, each `uneven_m` too high or too low.
std::vector<PlaneFeature> large_pieces(double uneven_m) {
  std::vector<PlaneFeature> leaves;
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k)
      leaves.push_back(leaf({2.0 * i, 2.0 * k, (i + k) % 2 == 0 ? uneven_m : -uneven_m}, 2.0, 0.001));
  }
  return leaves;
}

TEST(MergeCoplanar, MakesOneFeatureOfThePiecesOfAFloor) {
  std::vector<PlaneFeature> leaves = large_pieces(0.0);
  const std::vector<PlaneFeature> merged = merge_coplanar(leaves, {});
  ASSERT_EQ(merged.size(), 1U);
  EXPECT_TRUE(merged[0].merged);
  EXPECT_NEAR(std::abs(merged[0].normal_G.z()), 1.0, 1e-9);
  ASSERT_EQ(merged[0].observations.size(), 2U) << "one for each patch";
  EXPECT_GT(leaves[0].merged_share, 0.5);
}

TEST(MergeCoplanar, CountsUnevenPiecesLess) {
  std::vector<PlaneFeature> flat = large_pieces(0.0);
  std::vector<PlaneFeature> uneven = large_pieces(0.002);
  ASSERT_EQ(merge_coplanar(flat, {}).size(), 1U);
  ASSERT_EQ(merge_coplanar(uneven, {}).size(), 1U);
  EXPECT_LT(uneven[0].merged_share, 0.2 * flat[0].merged_share);
}

// Small pieces stand off by their own noise, however flat the floor is.
TEST(MergeCoplanar, DoesNotTakeTheNoiseOfSmallPiecesForUnevenness) {
  std::vector<PlaneFeature> large = large_pieces(0.0);
  ASSERT_EQ(merge_coplanar(large, {}).size(), 1U);
  std::vector<PlaneFeature> all = large_pieces(0.0);
  for (int i = 0; i < 40; ++i) all.push_back(leaf({0.15 * i, 7.5, i % 2 == 0 ? 0.004 : -0.004}, 0.25, 0.004));
  ASSERT_EQ(merge_coplanar(all, {}).size(), 1U);
  EXPECT_GT(all[0].merged_share, 0.9 * large[0].merged_share);
}

// Floors a metre apart, their pieces in no order, so that pieces that follow each other lie far apart or near. What is
// gone through for a floor must not depend on that.
TEST(MergeCoplanar, FindsAllPiecesOfManyFloorsInWhateverOrderTheyCome) {
  std::vector<PlaneFeature> in_order;
  for (int floor = 0; floor < 5; ++floor) {
    for (int i = 0; i < 12; ++i) {
      for (int k = 0; k < 12; ++k) in_order.push_back(leaf({1.0 * i, 1.0 * k, 1.0 * floor}, 1.0, 0.001));
    }
  }
  std::vector<PlaneFeature> dealt_out;
  for (std::size_t i = 0; i < in_order.size(); ++i) dealt_out.push_back(in_order[i * 301 % in_order.size()]);
  for (std::vector<PlaneFeature>* leaves : {&in_order, &dealt_out}) {
    const std::vector<PlaneFeature> merged = merge_coplanar(*leaves, {});
    EXPECT_EQ(5U, merged.size());
    for (const PlaneFeature& piece : *leaves) EXPECT_GT(piece.merged_share, 0.0);
  }
}

double weight_of(const std::vector<PlaneFeature>& features) {
  double sum = 0.0;
  for (const PlaneFeature& feature : features) {
    for (const PlaneObservation& o : feature.observations) sum += o.N * o.weight;
  }
  return sum;
}

TEST(MergeCoplanar, TakesOverWeightAndCountsNothingTwice) {
  std::vector<PlaneFeature> leaves = large_pieces(0.001);
  const double before = weight_of(leaves);
  const std::vector<PlaneFeature> merged = merge_coplanar(leaves, {});
  ASSERT_EQ(merged.size(), 1U);
  EXPECT_GT(weight_of(merged), 0.1 * before);
  EXPECT_NEAR(weight_of(leaves) + weight_of(merged), before, 1e-9 * before);
}

// Pieces known to 0.7 mm that stand 0.7 mm off show no unevenness; such that stand 2 mm off do.
TEST(MergeCoplanar, TakesNoiseForNoiseWhereItIsTrusted) {
  MergeOptions trusting;
  trusting.trust_noise = true;
  std::vector<PlaneFeature> noisy = large_pieces(0.0007);
  std::vector<PlaneFeature> noisy_trusted = noisy;
  std::vector<PlaneFeature> uneven = large_pieces(0.002);
  ASSERT_EQ(merge_coplanar(noisy, {}).size(), 1U);
  ASSERT_EQ(merge_coplanar(noisy_trusted, trusting).size(), 1U);
  ASSERT_EQ(merge_coplanar(uneven, trusting).size(), 1U);
  EXPECT_GT(noisy_trusted[0].merged_share, 1.5 * noisy[0].merged_share);
  EXPECT_LT(uneven[0].merged_share, 0.15);
}

}  // namespace
}  // namespace rigcal
