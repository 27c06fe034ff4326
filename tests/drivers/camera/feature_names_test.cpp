#include "drivers/camera/aravis/feature_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rigcal::camera {
namespace {

using testing::ElementsAre;

TEST(FeatureNames, KnowsTheVendorsByTheirNames) {
  EXPECT_EQ(vendor_of("Hikrobot"), Vendor::hikrobot);
  EXPECT_EQ(vendor_of("HIKVISION"), Vendor::hikrobot);
  EXPECT_EQ(vendor_of("Basler AG"), Vendor::basler);
  EXPECT_EQ(vendor_of("FLIR"), Vendor::flir);
  EXPECT_EQ(vendor_of("Point Grey Research"), Vendor::flir);
  EXPECT_EQ(vendor_of("Aravis"), Vendor::generic);
  EXPECT_EQ(vendor_of(""), Vendor::generic);
}

TEST(FeatureNames, TriesTheVendorsOwnNameFirst) {
  EXPECT_THAT(names_of(Purpose::exposure, Vendor::basler), ElementsAre("ExposureTimeAbs", "ExposureTime"));
  EXPECT_THAT(names_of(Purpose::exposure, Vendor::flir), ElementsAre("ExposureTime", "ExposureTimeAbs"));
  EXPECT_THAT(names_of(Purpose::frame_rate_enable, Vendor::flir),
              ElementsAre("AcquisitionFrameRateEnabled", "AcquisitionFrameRateEnable"));
  EXPECT_THAT(names_of(Purpose::strobe_mode, Vendor::hikrobot), ElementsAre("Strobe", "Output"));
}

TEST(FeatureNames, HasARowForEveryPurpose) {
  for (int i = 0; i <= static_cast<int>(kLastPurpose); ++i) {
    for (const Vendor vendor : {Vendor::generic, Vendor::hikrobot, Vendor::basler, Vendor::flir})
      EXPECT_FALSE(names_of(static_cast<Purpose>(i), vendor).empty()) << i;
  }
}

}  // namespace
}  // namespace rigcal::camera
