#!/usr/bin/env bash
# Usage: network_test.sh LIVEMVS SAMPLE-FOLDER
#
# The viewer as another machine meets it: two network namespaces joined by a cable, the program in
# one of them, a client in the other. Exits with 77, which CTest takes as skipped, where namespaces
# may not be made or there is no curl.

set -euo pipefail
livemvs="$1"
sample="$2"
here="livemvs-here-$$"
there="livemvs-there-$$"
folder="$(mktemp -d)"
program=""

skip() {
  echo "skipped: $1"
  exit 77
}
clean() {
  if [[ -n "$program" ]]; then kill -INT "$program" 2>/dev/null || true; fi
  wait 2>/dev/null || true
  ip netns del "$here" 2>/dev/null || true
  ip netns del "$there" 2>/dev/null || true
  rm -rf "$folder"
}
fail() {
  echo "FAILED: $1"
  cat "$folder/out"
  exit 1
}

for tool in ip curl openssl; do command -v "$tool" >/dev/null || skip "no $tool"; done
trap clean EXIT
ip netns add "$here" 2>"$folder/why" || skip "namespaces may not be made: $(cat "$folder/why")"
ip netns add "$there"
ip -n "$here" link add cable type veth peer name cable netns "$there" 2>"$folder/why" ||
  skip "no cable between namespaces: $(cat "$folder/why")"
for end in "$here 192.0.2.1" "$there 192.0.2.2"; do
  read -r name address <<<"$end"
  ip -n "$name" address add "$address/24" dev cable
  ip -n "$name" link set cable up
  ip -n "$name" link set lo up
done

# Starts the program in its namespace, and waits for its address.
serve() {
  : >"$folder/out" # what an earlier one printed is none of this one's
  ip netns exec "$here" "$livemvs" view "$sample/mesh.ply.gz" --no-browser --port 7451 "$@" >"$folder/out" 2>&1 &
  program=$!
  for _ in $(seq 300); do
    if grep -q '^viewer: http' "$folder/out"; then break; fi
    sleep 0.1
  done
  grep -q '^viewer: http' "$folder/out" || fail "it does not serve"
  url="$(sed -n 's/^viewer: \(http.*192\.0\.2\.1.*\)/\1/p' "$folder/out" | head -n 1)"
}
end() {
  kill -INT "$program"
  wait "$program" || fail "it ended with $?"
  program=""
}
# Status that a client at the other end of the cable gets; 000: no connection, or none that is HTTP.
status() { ip netns exec "$there" curl -sk -m 10 -o /dev/null -w '%{http_code}' "$@" || true; }
expect() {
  local wanted="$1" got
  shift
  got="$(status "$@")"
  [[ "$got" == "$wanted" ]] || fail "$got instead of $wanted: ${*//$token/TOKEN}"
}

serve --listen 192.0.2.1
[[ "$url" == https://192.0.2.1:7451/?token=* ]] || fail "no https address: $url"
token="${url##*token=}"
origin="https://192.0.2.1:7451"
expect 200 "$url"
expect 403 "$origin/"
expect 403 "$origin/?token=0123456789abcdef0123456789abcdef"
expect 403 "$origin/app.js"
expect 200 -b "livemvs_7451=$token" "$origin/app.js"
expect 421 -H "Host: evil.example:7451" "$url"
expect 000 "http://192.0.2.1:7451/?token=$token"

stream=(--http1.1 -H "Connection: Upgrade" -H "Upgrade: websocket" -H "Sec-WebSocket-Version: 13"
  -H "Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==" -m 3)
expect 101 "${stream[@]}" -b "livemvs_7451=$token" -H "Origin: $origin" "$origin/stream"
expect 403 "${stream[@]}" -H "Origin: $origin" "$origin/stream"
expect 403 "${stream[@]}" -b "livemvs_7451=$token" -H "Origin: https://evil.example" "$origin/stream"

printed="$(sed -n 's/^viewer: certificate SHA-256 //p' "$folder/out" | tr -d ': \n' | tr a-f A-F)"
met="$(ip netns exec "$there" openssl s_client -connect 192.0.2.1:7451 </dev/null 2>/dev/null |
  openssl x509 -noout -fingerprint -sha256 | sed 's/.*=//' | tr -d ':\n')"
[[ -n "$met" && "$met" == "$printed" ]] || fail "the certificate is $met, $printed was printed"
for old in -tls1 -tls1_1; do
  if ip netns exec "$there" openssl s_client "$old" -cipher 'ALL:@SECLEVEL=0' -connect 192.0.2.1:7451 \
    </dev/null >/dev/null 2>&1; then
    fail "it speaks $old"
  fi
done
end

# Without --listen nobody comes in from outside.
serve
token=none
expect 000 "http://192.0.2.1:7451/"
expect 000 "https://192.0.2.1:7451/"
end
echo "ok"
