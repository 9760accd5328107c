#include "livemvs/io/picture_codec.h"

extern "C" {
#include <libavutil/imgutils.h>
#include <libavutil/pixdesc.h>
}

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "livemvs/core/error.h"
#include "livemvs/io/atomic_file.h"
#include "livemvs/io/ffmpeg_util.h"
#include "livemvs/io/frame_convert.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMaxFileSize = std::int64_t{1} << 30;

/// The whole file, followed by the zeros that FFmpeg's decoders may read.
struct FileBytes {
  std::vector<std::uint8_t> data;
  std::size_t size = 0;
};

FileBytes ReadFile(const fs::path& path) {
  const std::string name = path.string();
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw BadInput(name + ": there is no such file");
  if (!fs::is_regular_file(status)) throw BadInput(name + ": is not an ordinary file");
  const auto size = static_cast<std::int64_t>(fs::file_size(path, error));
  if (error) throw BadInput(name + ": cannot be read: " + error.message());
  if (size == 0) throw BadInput(name + ": is empty (0 bytes)");
  if (size > kMaxFileSize) throw BadInput(name + ": is too large for an image (over 1 GB)");
  FileBytes bytes;
  bytes.size = static_cast<std::size_t>(size);
  bytes.data.resize(bytes.size + AV_INPUT_BUFFER_PADDING_SIZE);
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(bytes.data.data()), size);
  if (!in) throw BadInput(name + ": cannot be read; check its permissions");
  return bytes;
}

AVCodecID CodecOf(const fs::path& path, const FileBytes& bytes) {
  const auto starts_with = [&](std::initializer_list<std::uint8_t> magic) {
    return bytes.size > magic.size() && std::equal(magic.begin(), magic.end(), bytes.data.begin());
  };
  if (starts_with({0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'})) return AV_CODEC_ID_PNG;
  if (starts_with({0xff, 0xd8, 0xff})) return AV_CODEC_ID_MJPEG;
  if (starts_with({'P', '2'}) || starts_with({'P', '5'})) return AV_CODEC_ID_PGM;
  if (starts_with({'P', '3'}) || starts_with({'P', '6'})) return AV_CODEC_ID_PPM;
  throw BadInput(path.string() + ": is no PNG, JPEG, PGM or PPM image; convert it to one");
}

/// Whether a JPEG file goes on to its end marker. FFmpeg fills what is missing with grey.
bool JpegIsComplete(const FileBytes& bytes) {
  std::size_t i = 2;
  while (i + 1 < bytes.size) {
    if (bytes.data[i] != 0xff) {  // Entropy-coded data, where 0xff is followed by 0 or a restart.
      ++i;
      continue;
    }
    const std::uint8_t marker = bytes.data[i + 1];
    if (marker == 0xd9) return true;
    const bool has_length = marker >= 0xc0 && marker != 0xff && !(marker >= 0xd0 && marker <= 0xd8);
    if (marker == 0xff) {
      i += 1;
    } else if (!has_length || i + 3 >= bytes.size) {
      i += 2;
    } else {
      i += 2u + (bytes.data[i + 2] << 8 | bytes.data[i + 3]);
    }
  }
  return false;
}

ffmpeg::CodecContext OpenDecoder(const fs::path& path, AVCodecID id) {
  const AVCodec* codec = avcodec_find_decoder(id);
  if (codec == nullptr) {
    throw Error(
        ErrorKind::kFailed,
        path.string() + ": this FFmpeg was built without a decoder for " + avcodec_get_name(id));
  }
  ffmpeg::CodecContext decoder = ffmpeg::MakeCodecContext(codec);
  decoder->thread_count = 1;
  decoder->max_pixels = ffmpeg::kMaxPixels;
  // A damaged image is an error, not something to guess.
  decoder->err_recognition = AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER | AV_EF_EXPLODE;
  if (avcodec_open2(decoder.get(), codec, nullptr) < 0) throw std::bad_alloc();
  return decoder;
}

ffmpeg::Frame Decode(const fs::path& path) {
  ffmpeg::Silence();
  FileBytes bytes = ReadFile(path);
  const AVCodecID id = CodecOf(path, bytes);
  if (id == AV_CODEC_ID_MJPEG && !JpegIsComplete(bytes)) {
    throw BadInput(path.string() + ": the JPEG image ends early; copy it again");
  }
  ffmpeg::CodecContext decoder = OpenDecoder(path, id);
  ffmpeg::Packet packet = ffmpeg::MakePacket();
  packet->data = bytes.data.data();
  packet->size = static_cast<int>(bytes.size);
  ffmpeg::Frame frame = ffmpeg::MakeFrame();
  int result = avcodec_send_packet(decoder.get(), packet.get());
  if (result >= 0) result = avcodec_send_packet(decoder.get(), nullptr);
  if (result >= 0) result = avcodec_receive_frame(decoder.get(), frame.get());
  if (result == AVERROR(ENOMEM)) throw std::bad_alloc();
  if (result < 0 || (frame->flags & AV_FRAME_FLAG_CORRUPT) || frame->decode_error_flags != 0) {
    throw BadInput(path.string() + ": damaged image (" +
                   (result < 0 ? ffmpeg::ErrorText(result) : "decoded with errors") +
                   "), or larger than 16384 x 16384; copy or export it again");
  }
  if (frame->width > ffmpeg::kMaxSide || frame->height > ffmpeg::kMaxSide) {
    throw BadInput(path.string() + ": is larger than 16384 x 16384");
  }
  return frame;
}

bool IsGrey16(const AVFrame& frame) {
  return frame.format == AV_PIX_FMT_GRAY16LE || frame.format == AV_PIX_FMT_GRAY16BE;
}

Image<std::uint16_t> CopyGrey16(const AVFrame& frame) {
  Image<std::uint16_t> out(frame.width, frame.height);
  const int high = frame.format == AV_PIX_FMT_GRAY16BE ? 0 : 1;
  for (int y = 0; y < frame.height; ++y) {
    const std::uint8_t* row = frame.data[0] + std::ptrdiff_t{y} * frame.linesize[0];
    for (int x = 0; x < frame.width; ++x) {
      out(x, y) = static_cast<std::uint16_t>(row[2 * x + high] << 8 | row[2 * x + 1 - high]);
    }
  }
  return out;
}

/// Encodes rows of `row_bytes` bytes as PNG.
template <typename T>
void EncodePng(const fs::path& path, const Image<T>& image, AVPixelFormat format) {
  if (image.empty()) throw std::invalid_argument("WritePng: the image is empty");
  ffmpeg::Silence();
  const AVCodec* codec = avcodec_find_encoder(AV_CODEC_ID_PNG);
  if (codec == nullptr) {
    throw Error(ErrorKind::kFailed,
                path.string() + ": this FFmpeg was built without a PNG encoder");
  }
  AtomicFile file(path);
  ffmpeg::CodecContext encoder = ffmpeg::MakeCodecContext(codec);
  encoder->width = image.width();
  encoder->height = image.height();
  encoder->pix_fmt = format;
  encoder->time_base = {1, 1};
  encoder->thread_count = 1;
  if (avcodec_open2(encoder.get(), codec, nullptr) < 0) throw std::bad_alloc();
  ffmpeg::Frame frame = ffmpeg::MakeFrame();
  frame->width = image.width();
  frame->height = image.height();
  frame->format = format;
  if (av_frame_get_buffer(frame.get(), 0) < 0) throw std::bad_alloc();
  for (int y = 0; y < image.height(); ++y) {
    std::memcpy(frame->data[0] + std::ptrdiff_t{y} * frame->linesize[0],
                image.Row(y),
                static_cast<std::size_t>(image.width()) * sizeof(T));
  }
  ffmpeg::Packet packet = ffmpeg::MakePacket();
  if (avcodec_send_frame(encoder.get(), frame.get()) < 0 ||
      avcodec_send_frame(encoder.get(), nullptr) < 0 ||
      avcodec_receive_packet(encoder.get(), packet.get()) < 0) {
    throw Error(ErrorKind::kFailed, path.string() + ": PNG encoding failed");
  }
  file.Write(packet->data, static_cast<std::size_t>(packet->size));
  file.Commit();
}

}  // namespace

Picture ReadPicture(const fs::path& path) {
  const ffmpeg::Frame frame = Decode(path);
  if (IsGrey16(*frame)) {
    const Image<std::uint16_t> wide = CopyGrey16(*frame);
    Picture picture;
    picture.full_range = true;
    picture.grey = Image<std::uint8_t>(wide.width(), wide.height());
    for (int y = 0; y < wide.height(); ++y) {
      for (int x = 0; x < wide.width(); ++x) {
        picture.grey(x, y) = static_cast<std::uint8_t>((wide(x, y) + 128) / 257);
      }
    }
    return picture;
  }
  Picture picture = ffmpeg::FrameConverter().Convert(*frame);
  // Stills span the full range whatever their headers leave unsaid.
  picture.full_range = true;
  return picture;
}

Image<std::uint16_t> ReadDepthPng(const fs::path& path) {
  const ffmpeg::Frame frame = Decode(path);
  if (IsGrey16(*frame)) return CopyGrey16(*frame);
  if (frame->format != AV_PIX_FMT_GRAY8) {
    throw BadInput(path.string() + ": is no grey image; depth images are 16-bit grey PNG");
  }
  Image<std::uint16_t> out(frame->width, frame->height);
  for (int y = 0; y < frame->height; ++y) {
    const std::uint8_t* row = frame->data[0] + std::ptrdiff_t{y} * frame->linesize[0];
    std::copy(row, row + frame->width, out.Row(y));
  }
  return out;
}

void WritePng(const fs::path& path, const Image<std::uint8_t>& grey) {
  EncodePng(path, grey, AV_PIX_FMT_GRAY8);
}

void WritePng(const fs::path& path, const Image<Rgb>& rgb) {
  static_assert(sizeof(Rgb) == 3);
  EncodePng(path, rgb, AV_PIX_FMT_RGB24);
}

void WritePng(const fs::path& path, const Image<std::uint16_t>& depth) {
  // PNG is big-endian.
  Image<std::uint16_t> swapped(depth.width(), depth.height());
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      const std::uint16_t v = depth(x, y);
      swapped(x, y) = std::endian::native == std::endian::little
                          ? static_cast<std::uint16_t>(v << 8 | v >> 8)
                          : v;
    }
  }
  EncodePng(path, swapped, AV_PIX_FMT_GRAY16BE);
}

}  // namespace livemvs
