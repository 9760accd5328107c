import { defineConfig } from "vite";

// The program embeds the built page under fixed names: no hashes, one file of each kind.
export default defineConfig({
  base: "./",
  build: {
    outDir: "dist",
    emptyOutDir: true,
    target: "es2022",
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 900,
    modulePreload: false,
    rollupOptions: {
      output: {
        inlineDynamicImports: true,
        entryFileNames: "app.js",
        assetFileNames: (asset) => {
          const name = asset.names[0] ?? "";
          if (name.endsWith(".css")) return "app.css";
          if (name.endsWith(".woff2")) return "inter.woff2";
          return "[name][extname]";
        },
      },
    },
  },
});
