#include "livemvs/io/picture_codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <stdexcept>

#include "livemvs/io/image_source.h"
#include "livemvs/io/media_test_util.h"
#include "livemvs/io/video_writer.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class PictureCodecTest : public MediaTest {
 protected:
  /// A JPEG image, taken out of a Motion JPEG video: its packets are whole JPEG files.
  std::string MakeJpeg(const Picture& picture) {
    VideoWriterOptions options;
    options.width = picture.width();
    options.height = picture.height();
    options.encoder = "mjpeg";
    options.full_range = true;
    options.matrix = YuvMatrix::kBt601;
    VideoWriter writer(folder_ / "jpeg.avi", options);
    writer.Write(picture);
    writer.Finish();
    const std::string avi = ReadBytes(folder_ / "jpeg.avi");
    const std::size_t start = avi.find("\xff\xd8\xff");
    const std::size_t end = avi.find("\xff\xd9", start);
    return avi.substr(start, end + 2 - start);
  }

  static Picture FullRangePicture() {
    Picture picture = NumberedPicture(5, 160, 112);
    picture.full_range = true;
    picture.matrix = YuvMatrix::kBt601;
    return picture;
  }
};

TEST_F(PictureCodecTest, GreyPngComesBackBitForBit) {
  Image<std::uint8_t> grey(37, 21);
  for (int y = 0; y < 21; ++y) {
    for (int x = 0; x < 37; ++x) grey(x, y) = static_cast<std::uint8_t>(7 * x + 11 * y);
  }
  WritePng(folder_ / "a.png", grey);
  const Picture picture = ReadPicture(folder_ / "a.png");
  EXPECT_EQ(MeanDifference(picture.grey, grey), 0);
  EXPECT_TRUE(picture.cb.empty());
  EXPECT_TRUE(picture.full_range);
  EXPECT_EQ(ReadDepthPng(folder_ / "a.png")(3, 2), grey(3, 2));
}

TEST_F(PictureCodecTest, ColourPngKeepsItsColoursAndHasItsLuma) {
  Image<Rgb> rgb(64, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      rgb(x, y) = {static_cast<std::uint8_t>(4 * x),
                   static_cast<std::uint8_t>(5 * y),
                   static_cast<std::uint8_t>(255 - 2 * x - 2 * y)};
    }
  }
  WritePng(folder_ / "a.png", rgb);
  const Picture picture = ReadPicture(folder_ / "a.png");
  EXPECT_EQ(picture.chroma_shift_x, 0);
  EXPECT_EQ(picture.cb.width(), 64);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      const Rgb& c = rgb(x, y);
      EXPECT_NEAR(picture.grey(x, y), 0.299 * c[0] + 0.587 * c[1] + 0.114 * c[2], 1.01);
      const Rgb back = picture.ColorAt(x, y);
      for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(back[k], c[k], 3);
    }
  }
}

TEST_F(PictureCodecTest, DepthComesBackBitForBit) {
  Image<std::uint16_t> depth(50, 30);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 50; ++x) depth(x, y) = static_cast<std::uint16_t>(1310 * x + 7 * y);
  }
  WritePng(folder_ / "d.png", depth);
  const Image<std::uint16_t> back = ReadDepthPng(folder_ / "d.png");
  const Picture picture = ReadPicture(folder_ / "d.png");
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 50; ++x) {
      ASSERT_EQ(back(x, y), depth(x, y));
      ASSERT_NEAR(picture.grey(x, y), depth(x, y) / 257.0, 0.51);
    }
  }
  WritePng(folder_ / "c.png", Image<Rgb>(4, 4));
  EXPECT_THAT(BadInputMessage([&] { ReadDepthPng(folder_ / "c.png"); }), HasSubstr("no grey"));
}

TEST_F(PictureCodecTest, JpegKeepsItsPlanes) {
  const Picture written = FullRangePicture();
  WriteBytes(folder_ / "a.jpg", MakeJpeg(written));
  const Picture picture = ReadPicture(folder_ / "a.jpg");
  EXPECT_EQ(picture.chroma_shift_x, 1);
  EXPECT_EQ(picture.chroma_shift_y, 1);
  EXPECT_TRUE(picture.full_range);
  EXPECT_EQ(picture.matrix, YuvMatrix::kBt601);
  EXPECT_LT(MeanDifference(picture.grey, written.grey), 2);
  EXPECT_LT(MeanDifference(picture.cb, written.cb), 2);
}

TEST_F(PictureCodecTest, ReadsPortableMaps) {
  WriteBytes(folder_ / "a.pgm",
             std::string("P5\n# made by hand\n3 2\n255\n\x01\x02\x03\x04\x05\x06"));
  EXPECT_EQ(ReadPicture(folder_ / "a.pgm").grey(2, 1), 6);
  WriteBytes(folder_ / "b.pgm", std::string("P5\n2 1\n65535\n\x01\x02\xff\xff", 17));
  EXPECT_EQ(ReadDepthPng(folder_ / "b.pgm")(0, 0), 0x102);
  EXPECT_EQ(ReadPicture(folder_ / "b.pgm").grey(1, 0), 255);
  WriteBytes(folder_ / "c.ppm", std::string("P6\n1 1\n255\n\xc8\x10\x20"));
  EXPECT_NEAR(ReadPicture(folder_ / "c.ppm").ColorAt(0, 0)[0], 0xc8, 3);
}

TEST_F(PictureCodecTest, NamesWhatIsNoPicture) {
  const auto message = [&](const std::string& name, const std::string& bytes) {
    WriteBytes(folder_ / name, bytes);
    const std::string text = BadInputMessage([&] { ReadPicture(folder_ / name); });
    EXPECT_THAT(text, HasSubstr(name));
    return text;
  };
  EXPECT_THAT(BadInputMessage([&] { ReadPicture(folder_ / "none.png"); }), HasSubstr("no such"));
  EXPECT_THAT(BadInputMessage([&] { ReadPicture(folder_); }), HasSubstr("ordinary"));
  EXPECT_THAT(message("empty.png", ""), HasSubstr("empty"));
  EXPECT_THAT(message("text.png", "words"), HasSubstr("is no PNG"));
  message("magic.png", "\x89PNG\r\n\x1a\n");
  message("magic.jpg", "\xff\xd8\xff\xe0");
  message("huge.pgm", "P5\n2000000000 2000000000\n255\n");
  message("wide.pgm", "P5\n20000 1\n255\n" + std::string(20000, 'x'));
  message("short.pgm", "P5\n100 100\n255\nabc");
}

TEST_F(PictureCodecTest, FindsCutAndDamagedImages) {
  const std::string jpeg = MakeJpeg(FullRangePicture());
  WritePng(folder_ / "a.png", FullRangePicture().grey);
  const std::string png = ReadBytes(folder_ / "a.png");
  for (const std::string& good : {jpeg, png}) {
    for (const double share : {0.1, 0.5, 0.9, 0.99}) {
      const auto size = static_cast<std::size_t>(share * static_cast<double>(good.size()));
      WriteBytes(folder_ / "cut", good.substr(0, size));
      BadInputMessage([&] { ReadPicture(folder_ / "cut"); });
    }
  }
  std::string flipped = png;
  flipped[png.size() / 2] = static_cast<char>(flipped[png.size() / 2] ^ 4);
  WriteBytes(folder_ / "flip.png", flipped);
  BadInputMessage([&] { ReadPicture(folder_ / "flip.png"); });
}

TEST_F(PictureCodecTest, SurvivesRandomBytes) {
  const std::string jpeg = MakeJpeg(FullRangePicture());
  WritePng(folder_ / "a.png", FullRangePicture().grey);
  const std::string png = ReadBytes(folder_ / "a.png");
  std::mt19937 random(1);
  for (int trial = 0; trial < 300; ++trial) {
    std::string bad = trial % 2 ? jpeg : png;
    for (int flip = 0; flip < 5; ++flip) bad[random() % bad.size()] = static_cast<char>(random());
    WriteBytes(folder_ / "bad", bad);
    try {
      EXPECT_FALSE(ReadPicture(folder_ / "bad").grey.empty());
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kBadInput) << error.what();
    }
  }
}

TEST_F(PictureCodecTest, RefusesToWriteNothing) {
  EXPECT_THROW(WritePng(folder_ / "a.png", Image<std::uint8_t>()), std::invalid_argument);
  EXPECT_THROW(WritePng(folder_ / "no" / "a.png", Image<std::uint8_t>(2, 2)), Error);
}

// --- Folders of images ---------------------------------------------------------------------------

using ImageSourceTest = MediaTest;

TEST_F(ImageSourceTest, SortsNumbersAsNumbers) {
  EXPECT_TRUE(NaturalLess("img2", "img10"));
  EXPECT_FALSE(NaturalLess("img10", "img2"));
  EXPECT_TRUE(NaturalLess("img02", "img3"));
  EXPECT_TRUE(NaturalLess("a", "b"));
  EXPECT_TRUE(NaturalLess("a1", "a1b"));
  EXPECT_TRUE(NaturalLess("a99999999999999999999999998", "a99999999999999999999999999"));
  EXPECT_NE(NaturalLess("a01", "a1"), NaturalLess("a1", "a01"));
  EXPECT_FALSE(NaturalLess("a1", "a1"));
}

TEST_F(ImageSourceTest, ListsImagesOnly) {
  for (const char* name : {"f10.png", "f9.JPG", ".hidden.png", "notes.txt", "f1.pgm"}) {
    WriteBytes(folder_ / name, "x");
  }
  fs::create_directory(folder_ / "folder.png");
  EXPECT_THAT(ListImages(folder_),
              ::testing::ElementsAre(folder_ / "f1.pgm", folder_ / "f9.JPG", folder_ / "f10.png"));
  BadInputMessage([&] { ListImages(folder_ / "missing"); });
}

TEST_F(ImageSourceTest, PassesOverUnreadableImages) {
  std::vector<fs::path> files;
  for (int i = 0; i < 5; ++i) {
    files.push_back(folder_ / ("f" + std::to_string(i) + ".png"));
    WritePng(files.back(), NumberedPicture(i, 160, 112).grey);
  }
  WriteBytes(files[0], "damaged");
  fs::remove(files[3]);
  const auto source = OpenImages(files, 10);
  EXPECT_EQ(source->info().width, 160);
  EXPECT_EQ(source->info().frame_count, 5);
  std::vector<std::int64_t> indices;
  while (auto frame = source->Next()) {
    indices.push_back(frame->index);
    EXPECT_EQ(NumberIn(*frame->picture), frame->index);
    EXPECT_DOUBLE_EQ(frame->timestamp, static_cast<double>(frame->index) / 10);
    EXPECT_EQ(frame->name, "f" + std::to_string(frame->index) + ".png");
  }
  EXPECT_THAT(indices, ::testing::ElementsAre(1, 2, 4));
  EXPECT_EQ(source->statistics().decoded, 3);
  EXPECT_EQ(source->statistics().skipped, 2);
  EXPECT_FALSE(source->Next());
  ASSERT_THAT(warnings_, ::testing::SizeIs(1));
  EXPECT_THAT(warnings_[0], HasSubstr("f0.png"));
}

TEST_F(ImageSourceTest, NeedsOneGoodImage) {
  BadInputMessage([&] { OpenImages({}); });
  WriteBytes(folder_ / "a.png", "damaged");
  EXPECT_THAT(BadInputMessage([&] { OpenImages({folder_ / "a.png"}); }), HasSubstr("a.png"));
  EXPECT_THROW(OpenImages({folder_ / "a.png"}, 0), std::invalid_argument);
}

}  // namespace
}  // namespace livemvs
