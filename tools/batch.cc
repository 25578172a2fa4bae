#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "batch_fleet.h"
#include "batch_slurm.h"
#include "child_program.h"
#include "commands.h"
#include "crc32.h"
#include "dataset/content_hash.h"
#include "dataset/dataset.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/text_encoding.h"
#include "fleet/batch_plan.h"
#include "fleet/fleet_analysis.h"
#include "fleet/fleet_mean.h"
#include "fleet/fleet_page.h"
#include "fleet/fleet_table.h"
#include "help_formatter.h"
#include "progress_bar.h"
#include "target/board_spec.h"
#include "unit_lock.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;
using BatchJson = nlohmann::ordered_json;

constexpr char kUnitFile[] = "unit.json";  // the last file of a finished unit
constexpr int kUnitSchemaVersion = 3;      // version of unit.json and of
                                           // failures
constexpr char kFleetFile[] = "fleet.csv";
constexpr char kFleetPage[] = "fleet.html";
constexpr char kFleetCamera[] = "fleet_camera.yaml";

struct BatchArguments {
  std::string plan, output;
  std::string units;  // "N", "N-M" or empty
  bool gather = false, slurm = false;
};

// A unit of the plan, resolved on this machine.
struct UnitJob {
  BatchUnit unit;  // with paths relative to the working directory
  std::string folder, failure_file;
};

// ---- Planning --------------------------------------------------------------

// Resolves a path of the plan, which is relative to the plan's folder.
std::string Resolve(const fs::path& base, const std::string& path) {
  return path.empty() ? path : (base / path).string();
}

std::vector<UnitJob> MakeJobs(const BatchPlan& plan,
                              const BatchArguments& arguments) {
  fs::path base = fs::path(arguments.plan).parent_path();
  if (base.empty()) base = ".";
  std::vector<UnitJob> jobs;
  for (const BatchUnit& unit : plan.units) {
    const std::string folder =
        (fs::path(arguments.output) / unit.serial).string();
    jobs.push_back({unit, folder, folder + ".failed.json"});
    BatchUnit& resolved = jobs.back().unit;
    if (!IsBoardSpec(unit.pattern))
      resolved.pattern = Resolve(base, unit.pattern);
    resolved.images = Resolve(base, unit.images);
    resolved.features = Resolve(base, unit.features);
    for (auto* paths :
         {&resolved.option_files, &resolved.cameras, &resolved.cameras_at})
      for (auto& [name, path] : *paths) path = Resolve(base, path);
  }
  return jobs;
}

void HashFolder(const std::string& folder, ContentHash* hash) {
  std::vector<std::string> files;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end;
       !error && it != end; it.increment(error))
    if (it->is_regular_file(error)) files.push_back(it->path().string());
  if (error)
    throw InputError(
        fmt::format("{}: cannot be read ({}); check name and permissions",
                    folder, error.message()));
  std::sort(files.begin(), files.end());
  for (const std::string& file : files) {
    hash->Add(fs::path(file).lexically_relative(folder).string());
    hash->Add(ReadFile(file));
  }
}

// Returns a hash of a unit's inputs, its options and the program version: a
// result with the same hash is up to date. Throws InputError if an input cannot
// be read.
std::string Fingerprint(const BatchUnit& unit, uint64_t seed) {
  ContentHash hash;
  hash.Add(RAYGRID_VERSION);
  hash.Add(fmt::format("{}", seed));
  hash.Add(IsBoardSpec(unit.pattern) ? unit.pattern : ReadFile(unit.pattern));
  for (const std::string& option : unit.options) hash.Add(option);
  for (const auto& [option, path] : unit.option_files)
    hash.Add(option + " " + ReadFile(path));
  if (!unit.features.empty()) hash.Add(ReadFile(unit.features));
  if (!unit.images.empty()) HashFolder(unit.images, &hash);
  for (const auto* folders : {&unit.cameras, &unit.cameras_at})
    for (const auto& [name, folder] : *folders) {
      hash.Add(name);
      HashFolder(folder, &hash);
    }
  return hash.Text();
}

// Returns the record in a unit's last file; nullopt if the file does not exist.
std::optional<BatchJson> ReadRecord(const std::string& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return std::nullopt;
  const BatchJson record = BatchJson::parse(ReadFile(path), nullptr, false);
  return record.is_object() ? std::optional(record) : std::nullopt;
}

uint32_t ComputeCrc32(const std::string& bytes) {
  return rg_crc32(0, reinterpret_cast<const uint8_t*>(bytes.data()),
                  static_cast<uint32_t>(bytes.size()));
}

// Returns the result files of a unit, including those of a rig's cameras:
// names, sizes and CRCs.
BatchJson ListResultFiles(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& file : fs::recursive_directory_iterator(folder))
    if (file.is_regular_file())
      names.push_back(file.path().lexically_relative(folder).string());
  std::sort(names.begin(), names.end());
  BatchJson files = BatchJson::array();
  for (const std::string& name : names) {
    if (name == kUnitFile) continue;
    const std::string bytes = ReadFile((fs::path(folder) / name).string());
    files.push_back({{"name", name},
                     {"bytes", bytes.size()},
                     {"crc32", ComputeCrc32(bytes)}});
  }
  return files;
}

// Throws InputError if a result file is missing or its contents have changed,
// for example after a power loss or on a full disk.
void RequireComplete(const std::string& folder, const BatchJson& record) {
  const BatchJson files = record.value("files", BatchJson());
  if (!files.is_array() || files.empty())
    throw InputError(folder + "/" + kUnitFile +
                     ": does not list the result's files; run the batch again");
  for (const BatchJson& file : files) {
    const bool is_known = file.is_object() && file.contains("name") &&
                          file["name"].is_string() && file.contains("bytes") &&
                          file.contains("crc32");
    const std::string path =
        folder + "/" + (is_known ? file["name"].get<std::string>() : "");
    std::error_code error;
    if (!is_known || !fs::is_regular_file(path, error) || error)
      throw InputError(path + ": missing; run the batch again");
    const auto size = fs::file_size(path, error);
    if (error || file["bytes"] != size)
      throw InputError(
          fmt::format("{}: {} bytes instead of {}; run the batch again", path,
                      error ? 0 : size, file["bytes"].dump()));
    if (file["crc32"] != ComputeCrc32(ReadFile(path)))
      throw InputError(
          path + ": CRC mismatch, the file was modified; run the batch again");
  }
}

// Returns the table row of a finished unit. Throws InputError if its result is
// no longer complete.
UnitRow ReadResult(const UnitJob& job, const BatchJson& record,
                   const MetricLimits& limits) {
  RequireComplete(job.folder, record);
  UnitRow row = ReadUnitRow(job.unit.serial, job.folder, limits);
  row.seconds =
      record.value(record.contains("elapsed_s") ? "elapsed_s" : "seconds", 0.0);
  return row;
}

// Returns the hash of inputs in a record; "inputs" in files before
// schema_version 2.
std::string ReadFingerprint(const BatchJson& record) {
  return record.value(record.contains("inputs_hash") ? "inputs_hash" : "inputs",
                      "");
}

bool IsFinished(const UnitJob& job, const std::string& fingerprint) {
  const auto record = ReadRecord(job.folder + "/" + kUnitFile);
  if (!record || ReadFingerprint(*record) != fingerprint) return false;
  try {
    ReadResult(job, *record, {});
    return true;
  } catch (const InputError&) {
    return false;
  }
}

// ---- One unit --------------------------------------------------------------

// Features of several cameras belong to a rig. Malformed features are left for
// the calibration to report.
bool IsRig(const BatchUnit& unit) {
  if (unit.features.empty()) return !unit.cameras.empty();
  try {
    return ParseFeatures(unit.features, ReadFile(unit.features)).size() > 1;
  } catch (const InputError&) {
    return false;
  }
}

std::vector<std::string> MakeUnitArguments(const UnitJob& job,
                                           const CommonOptions& common) {
  const BatchUnit& unit = job.unit;
  std::vector<std::string> words = {"calibrate", "--quiet"};
  words.push_back(fmt::format("--threads={}", common.threads));
  const bool has_seed = std::any_of(
      unit.options.begin(), unit.options.end(), [](const std::string& option) {
        return option.compare(0, 7, "--seed=") == 0;
      });
  if (!has_seed) words.push_back(fmt::format("--seed={}", common.seed));
  words.push_back("--pattern=" + unit.pattern);
  words.push_back("--output=" + job.folder);
  if (!IsRig(unit)) words.push_back("--serial=" + unit.serial);
  // The units of a fleet are compared with each other, so all use one model.
  if (std::none_of(unit.options.begin(), unit.options.end(),
                   [](const std::string& option) {
                     return option.compare(0, 8, "--model=") == 0;
                   }))
    words.push_back("--model=central-generic");
  words.insert(words.end(), unit.options.begin(), unit.options.end());
  for (const auto& [key, path] : unit.option_files) {
    std::string option = key;
    std::replace(option.begin(), option.end(), '_', '-');
    words.push_back("--" + option + "=" + path);
  }
  for (const auto& [camera, folder] : unit.cameras)
    words.push_back("--camera=" + camera + "=" + folder);
  for (const auto& [value, folder] : unit.cameras_at)
    words.push_back("--images-at=" + value + "=" + folder);
  if (!unit.features.empty()) words.push_back("--features=" + unit.features);
  if (!unit.images.empty()) {
    words.push_back("--");
    words.push_back(unit.images);
  }
  return words;
}

void RecordFailure(const UnitJob& job, int exit_code,
                   const std::string& reason) {
  rmdir(job.folder.c_str());  // fails if the folder contains an earlier result
  WriteFile(job.failure_file, BatchJson({{"schema_version", kUnitSchemaVersion},
                                         {"exit_code", exit_code},
                                         {"reason", reason}})
                                      .dump(2) +
                                  "\n");
}

// Whether a result could be written next to the unit's folder. If so, only that
// folder is not writable, for example because it is a file or belongs to
// another user.
bool HasRoom(const UnitJob& job) {
  constexpr size_t kResultBytes = 4 << 20;
  const std::string path = job.folder + ".room";
  try {
    WriteFile(path, std::string(kResultBytes, 'x'));
  } catch (const Error&) {
    return false;
  }
  return unlink(path.c_str()) == 0;
}

void CalibrateUnit(const UnitJob& job, const std::string& fingerprint,
                   const CommonOptions& common) {
  const std::string record = job.folder + "/" + kUnitFile;
  unlink(record.c_str());  // the folder's contents may now change
  const auto start = std::chrono::steady_clock::now();
  const ChildEnd end = RunChild(MakeUnitArguments(job, common));
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start)
          .count();
  const int code =
      end.signal ? static_cast<int>(ExitCode::kInvalidInput) : end.exit_code;
  if (code == static_cast<int>(ExitCode::kOutputFailed) && !HasRoom(job))
    throw Error(ExitCode::kOutputFailed,
                job.unit.serial + ": " + end.last_error);
  const bool is_done =
      code == 0 || code == static_cast<int>(ExitCode::kQualityTooLow);
  if (end.signal || !is_done || !fs::exists(job.folder + "/result.json")) {
    RecordFailure(
        job, code,
        end.signal
            ? fmt::format("the calibration was terminated by signal {} ({})",
                          end.signal, strsignal(end.signal))
            : end.last_error);
    return;
  }
  WriteFile(record, BatchJson({{"schema_version", kUnitSchemaVersion},
                               {"inputs_hash", fingerprint},
                               {"elapsed_s", seconds},
                               {"files", ListResultFiles(job.folder)}})
                            .dump(2) +
                        "\n");
  unlink(job.failure_file.c_str());
}

struct PendingUnit {
  const UnitJob* job;
  std::string fingerprint;
};

// Returns the unfinished units. Units with unreadable inputs are recorded as
// failed; their earlier results are kept.
std::vector<PendingUnit> FindPending(const std::vector<const UnitJob*>& jobs,
                                     uint64_t seed) {
  std::vector<PendingUnit> pending;
  for (const UnitJob* job : jobs) try {
      const std::string fingerprint = Fingerprint(job->unit, seed);
      if (!IsFinished(*job, fingerprint))
        pending.push_back({job, fingerprint});
      else
        unlink(job->failure_file.c_str());
    } catch (const InputError& error) {
      RecordFailure(*job, static_cast<int>(ExitCode::kInvalidInput),
                    error.what());
    }
  return pending;
}

void RunUnits(const std::vector<const UnitJob*>& jobs,
              const std::string& output, const CommonOptions& common) {
  const std::vector<PendingUnit> pending = FindPending(jobs, common.seed);
  RequireWritableFolder(output);  // for the locks
  ProgressBar bar(common.quiet);
  for (size_t k = 0; k < pending.size(); ++k) {
    bar.Show(fmt::format("{} ({} of {})", pending[k].job->unit.serial, k + 1,
                         pending.size()),
             static_cast<double>(k) / static_cast<double>(pending.size()));
    const UnitJob& job = *pending[k].job;
    const UnitLock lock(output, job.unit.serial);
    // Another process may have calibrated the unit in the meantime.
    if (!IsFinished(job, pending[k].fingerprint))
      CalibrateUnit(job, pending[k].fingerprint, common);
  }
}

// ---- All units -------------------------------------------------------------

UnitRow ReadRow(const UnitJob& job, const MetricLimits& limits) {
  UnitRow row;
  row.serial = job.unit.serial;
  if (const auto failure = ReadRecord(job.failure_file)) {
    row.status = "error";
    row.reason = failure->value("reason", "");
    row.exit_code = failure->value("exit_code", 2);
    return row;
  }
  std::error_code ignored;
  if (fs::exists(job.failure_file, ignored)) {
    row.status = "error";
    row.reason = job.failure_file + ": corrupt; run the batch again";
    row.exit_code = static_cast<int>(ExitCode::kInvalidInput);
    return row;
  }
  const auto record = ReadRecord(job.folder + "/" + kUnitFile);
  if (!record) {
    row.reason = "not calibrated yet";
    row.exit_code = static_cast<int>(ExitCode::kInvalidInput);
    return row;
  }
  try {
    return ReadResult(job, *record, limits);
  } catch (const InputError& error) {
    row.status = "error";
    row.reason = error.what();
    row.exit_code = static_cast<int>(ExitCode::kInvalidInput);
    return row;
  }
}

std::vector<UnitRow> ReadRows(const std::vector<const UnitJob*>& jobs,
                              const MetricLimits& limits) {
  std::vector<UnitRow> rows;
  for (const UnitJob* job : jobs) {
    rows.push_back(ReadRow(*job, limits));
    UnitRow& row = rows.back();
    row.lens_batch = job->unit.lens_batch;
    row.repeats = job->unit.repeats;
    row.person = job->unit.person;
    row.station = job->unit.station;
  }
  return rows;
}

// Returns 6 if any unit fails; otherwise the exit code of the first unit
// without a result.
int ComputeExitCode(const std::vector<UnitRow>& rows) {
  int code = 0;
  for (const UnitRow& row : rows) {
    if (row.status == "fail") return static_cast<int>(ExitCode::kQualityTooLow);
    if (code == 0 && HasNoResult(row)) code = row.exit_code;
  }
  return code;
}

std::optional<size_t> ParseUnitNumber(const std::string& text) {
  constexpr size_t kMaxDigits = 9;
  if (text.empty() || text.size() > kMaxDigits ||
      text.find_first_not_of("0123456789") != std::string::npos)
    return std::nullopt;
  return std::stoul(text);
}

// Returns the jobs selected by a range such as "3" or "3-7"; all jobs if it is
// empty.
std::vector<const UnitJob*> ChooseJobs(const std::vector<UnitJob>& jobs,
                                       const std::string& words) {
  const size_t dash = words.find('-');
  const auto first = words.empty() ? std::optional<size_t>(0)
                                   : ParseUnitNumber(words.substr(0, dash));
  const auto last = words.empty() ? std::optional<size_t>(jobs.size() - 1)
                    : dash == std::string::npos
                        ? first
                        : ParseUnitNumber(words.substr(dash + 1));
  if (!first || !last || *last < *first)
    throw Error(ExitCode::kUsage,
                fmt::format("--unit {}: expected a unit such as 3, or a range "
                            "such as 3-7",
                            Printable(words)));
  if (*last >= jobs.size())
    throw Error(
        ExitCode::kUsage,
        fmt::format(
            "--unit {}: out of range; the plan has {} units, numbered from 0",
            words, jobs.size()));
  std::vector<const UnitJob*> chosen;
  for (size_t k = *first; k <= *last; ++k) chosen.push_back(&jobs[k]);
  return chosen;
}

// Returns the folders that contain a unit's images.
std::vector<std::string> ImageFolders(const BatchUnit& unit) {
  std::vector<std::string> folders;
  if (!unit.images.empty()) folders.push_back(unit.images);
  for (const auto* more : {&unit.cameras, &unit.cameras_at})
    for (const auto& [name, folder] : *more) folders.push_back(folder);
  return folders;
}

// Rejects result folders inside image folders: the calibration would read its
// own output as input.
void RequireSeparateResultFolders(const std::vector<UnitJob>& jobs) {
  std::error_code ignored;
  for (const UnitJob& job : jobs) {
    const fs::path result =
        fs::weakly_canonical(fs::absolute(job.folder), ignored);
    for (const std::string& images : ImageFolders(job.unit)) {
      const fs::path folder = fs::canonical(images, ignored);
      if (!folder.empty() && std::mismatch(folder.begin(), folder.end(),
                                           result.begin(), result.end())
                                     .first == folder.end())
        throw Error(
            ExitCode::kOutputFailed,
            fmt::format("{}: the result of unit {} would be written into its "
                        "image folder; use another folder with -o",
                        job.folder, job.unit.serial));
    }
  }
}

void RunBatch(const BatchArguments& arguments, const CommonOptions& common) {
  const BatchPlan plan =
      ParseBatchPlan(arguments.plan, ReadFile(arguments.plan));
  const std::vector<UnitJob> jobs = MakeJobs(plan, arguments);
  const std::vector<const UnitJob*> chosen = ChooseJobs(jobs, arguments.units);
  RequireSeparateResultFolders(jobs);
  RequireCreatableFolder(arguments.output);
  const auto output = [&](const char* name) {
    return (fs::path(arguments.output) / name).string();
  };
  // Units calibrated with the population mean as prior would change that mean.
  std::vector<std::string> inputs = {arguments.plan};
  for (const UnitJob& job : jobs)
    for (const auto& [option, path] : job.unit.option_files)
      inputs.push_back(path);
  RequireNoInputReplaced(
      inputs, {output(kFleetFile), output(kFleetPage), output(kFleetCamera)});
  if (arguments.slurm)
    return SubmitToSlurm(arguments.plan, arguments.output, jobs.size(), common);
  if (!arguments.gather) RunUnits(chosen, arguments.output, common);
  std::vector<std::string> folders;
  for (const UnitJob* job : chosen) folders.push_back(job->folder);
  const FleetAnalysis fleet =
      AnalyseFleet(ReadRows(chosen, plan.limits), folders, plan.limits);
  if (arguments.units.empty()) {
    OutputFiles files;
    files.Add(output(kFleetFile), FormatFleetTable(fleet.rows));
    files.Add(output(kFleetPage), FormatFleetPage(fleet));
    if (const auto mean = ComputeMeanCamera(fleet, folders))
      files.Add(output(kFleetCamera), FormatCameraFile(*mean));
    files.Commit();
  }
  PrintUnits(fleet, common);
  if (const int code = ComputeExitCode(fleet.rows))
    throw CLI::RuntimeError(code);
}

}  // namespace

void AddBatch(CLI::App* app, CommonOptions* common) {
  CLI::App* command =
      AddCommand(app, "batch", "Calibrate many units and analyse the fleet.",
                 "raygrid batch plan.yaml -o out/", common);
  command->footer(
      "plan.yaml (paths are relative to its folder):\n"
      "  raygrid_batch: 1\n"
      "  pattern: board/pattern.yaml   # or a specification\n"
      "  model: central-generic        # any option of calibrate, with _ "
      "instead\n"
      "                                # of -: image_size, area, ...\n"
      "  limits: {held_out_median_px: 0.2, focal_px: [790, 810]}\n"
      "  units:\n"
      "    - {serial: A001, images: A001/}\n"
      "    - {serial: A002, features: A002.csv, image_size: [640, 480]}\n"
      "    - {serial: R001, cameras: {left: R001/l, right: R001/r}}\n\n" +
      command->get_footer());
  auto arguments = std::make_shared<BatchArguments>();
  command
      ->add_option("plan", arguments->plan,
                   "plan.yaml, which lists units and options")
      ->required();
  CLI::Option* const unit =
      command
          ->add_option(
              "--unit", arguments->units,
              "calibrate only unit I, or units I to J (0-based, in the order "
              "of serial numbers), without writing fleet files")
          ->option_text("I[-J]");
  CLI::Option* const gather =
      command
          ->add_flag("--gather", arguments->gather,
                     "do not calibrate, only write fleet.csv and fleet.html")
          ->excludes(unit);
  command
      ->add_flag("--slurm", arguments->slurm,
                 "submit a Slurm array job with --threads per task (default: "
                 "1), and a job that gathers the results")
      ->excludes(unit)
      ->excludes(gather);
  BeginGroup(command, help_group::kOutput);
  command
      ->add_option("-o,--output", arguments->output,
                   "folder for fleet.csv, fleet.html and one result per unit")
      ->option_text("DIR")
      ->required();
  command->callback([arguments, common] { RunBatch(*arguments, *common); });
}

}  // namespace raygrid
