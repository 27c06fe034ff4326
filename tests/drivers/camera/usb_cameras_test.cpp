#include "drivers/camera/aravis/usb_cameras.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/scratch_folder.h"

namespace rigcal::camera {
namespace {

namespace fs = std::filesystem;

class UsbCameras : public testing::Test {
 protected:
  void add(const std::string& place, const std::string& file, const std::string& text) {
    fs::create_directories(scratch / "sys" / place);
    std::ofstream(scratch / "sys" / place / file) << text << "\n";
  }
  void add_camera(const std::string& place, const std::string& device_class, const std::string& subclass) {
    add(place, "manufacturer", "Hikrobot");
    add(place, "product", "MV-CA013-21UC");
    add(place, "serial", "00F12345678");
    add(place, "busnum", "2");
    add(place, "devnum", "7");
    add(place + "/" + place + ":1.0", "bInterfaceClass", device_class);
    add(place + "/" + place + ":1.0", "bInterfaceSubClass", subclass);
  }
  std::vector<UsbCamera> list() { return list_usb_cameras((scratch / "sys").string(), (scratch / "nodes").string()); }
  std::filesystem::path scratch = scratch_folder("usb_cameras");
};

TEST_F(UsbCameras, AreFoundByTheClassOfTheirInterface) {
  add_camera("2-1", "ef", "05");
  add_camera("2-2", "08", "06");
  const auto cameras = list();
  ASSERT_EQ(cameras.size(), 1U);
  EXPECT_EQ(cameras[0].serial, "00F12345678");
  EXPECT_EQ(cameras[0].vendor, "Hikrobot");
  EXPECT_EQ(cameras[0].node, (scratch / "nodes" / "002" / "007").string());
}

TEST_F(UsbCameras, SayWhetherTheyMayBeOpened) {
  add_camera("2-1", "ef", "05");
  EXPECT_FALSE(list()[0].is_allowed);
  fs::create_directories(scratch / "nodes" / "002");
  std::ofstream(scratch / "nodes" / "002" / "007") << "";
  EXPECT_TRUE(list()[0].is_allowed);
}

TEST_F(UsbCameras, AMachineWithoutUsbHasNone) { EXPECT_TRUE(list().empty()); }

}  // namespace
}  // namespace rigcal::camera
